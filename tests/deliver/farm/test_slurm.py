"""`--submit slurm`: the script, on a real Slurm of one node."""

import re
import subprocess
from pathlib import Path

import pytest

from heatlens.deliver.farm.job import FRAMES, FarmJob, Needs, Place, Step
from heatlens.deliver.farm.slurm import slurm_script
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import write_shot
from support.exports import MANY, exported, files_in, shot_of, write_plates, write_shot_file
from support.slurm import Slurm, wait_for, why_not

REAL = pytest.mark.skipif(bool(why_not()), reason=why_not() or "a Slurm can be started")


@pytest.fixture(scope="module")
def slurm(tmp_path_factory):
    cluster = Slurm(tmp_path_factory.mktemp("slurm"))
    try:
        cluster.start()
        yield cluster
    finally:
        cluster.stop()


def script_of(capsys, *words: object) -> str:
    more = ("--submit", "slurm", "--memory", "1", "--cpus", "1")
    assert main(["export", *map(str, words), *more]) == 0
    return capsys.readouterr().out


def logs(folder: Path) -> str:
    return "".join(path.read_text() for path in folder.glob("slurm-*.out"))


@REAL
@pytest.mark.parametrize("output", ["n.####.exr", "m.mov"])
def test_a_cluster_makes_what_one_machine_makes(capsys, shot_file, tmp_path, slurm, output):
    exported(capsys, shot_file, tmp_path / "whole" / output)
    script = script_of(capsys, shot_file, "-o", tmp_path / "out" / output, "--chunk", 2)
    run = slurm.submitted(script, tmp_path)
    assert run.returncode == 0, run.stderr
    assert len(run.stdout.split()) == (2 if output == "m.mov" else 1)
    slurm.drained()
    assert files_in(tmp_path / "out") == files_in(tmp_path / "whole"), logs(tmp_path)
    assert not list((tmp_path / "out").glob("*.frames"))


@REAL
def test_names_with_any_character_arrive(capsys, tmp_path, slurm):
    """Blanks, quotes, %, {{, dollars and line ends."""
    odd = tmp_path / "a 'b' \"c\" %j {{d}} $HOME `e`\nEND\n#"
    odd.mkdir()
    shot = write_shot_file(odd)
    words = ("--frames", "1001-1002", "--burn-in", "--burn-in-text", "F {frame} 'x' $y\nEND\nz")
    exported(capsys, shot, tmp_path / "whole" / "n.####.png", *words)
    script = script_of(capsys, shot, "-o", odd / "out" / "n.####.png", "--chunk", 1, *words)
    assert slurm.submitted(script, tmp_path).returncode == 0
    slurm.drained()
    assert files_in(odd / "out") == files_in(tmp_path / "whole"), logs(tmp_path)


@REAL
def test_a_movie_is_not_made_where_a_frame_fails(capsys, shot_file, tmp_path, slurm):
    script = script_of(capsys, shot_file, "-o", tmp_path / "m.mov", "--chunk", 2)
    (tmp_path / "plates" / "plate.1003.exr").write_bytes(b"")
    assert slurm.submitted(script, tmp_path).returncode == 0
    slurm.drained()
    assert not (tmp_path / "m.mov").exists()
    assert "plate.1003.exr is empty" in logs(tmp_path)
    assert len(files_in(tmp_path / "m.mov.frames")) == 4


def many(folder: Path, frames: tuple[int, ...] = MANY) -> Path:
    shot = folder / "s.heatlens.json"
    write_shot(shot, shot_of(write_plates(folder / "plates", frames), frames))
    return shot


@REAL
@pytest.mark.parametrize("turn", [0, 1])
def test_a_killed_task_loses_nothing_that_one_more_start_does_not_make(
    capsys, tmp_path, slurm, turn
):
    """Killed as the node would do it for want of memory; what is finished stays as it is."""
    shot, out = many(tmp_path), tmp_path / "out"
    exported(capsys, shot, tmp_path / "whole" / "n.####.exr", "--proxy", "1")
    script = script_of(capsys, shot, "-o", out / "n.####.exr", "--chunk", 12, "--proxy", "1")
    ids = slurm.submitted(script, tmp_path).stdout.split()
    wait_for(lambda: len(list(out.glob("n.*.exr"))) > 3 * turn)
    slurm.said("scancel", "--signal=KILL", "--full", f"{ids[0]}_{turn}")
    slurm.drained()
    before = {path: path.stat().st_ino for path in out.glob("n.*.exr")}
    assert slurm.submitted(script, tmp_path).returncode == 0
    slurm.drained()
    assert files_in(out) == files_in(tmp_path / "whole")
    assert all(path.stat().st_ino == inode for path, inode in before.items())


@REAL
@pytest.mark.parametrize("turn", [0, 1])
def test_a_node_that_dies_comes_back_to_the_work(capsys, tmp_path, slurm, turn):
    """The tasks of a node that does not answer are put into the queue again."""
    shot, out = many(tmp_path, MANY[:12]), tmp_path / "out"  # two tasks run, and two wait
    exported(capsys, shot, tmp_path / "whole" / "n.####.exr")
    script = script_of(capsys, shot, "-o", out / "n.####.exr", "--chunk", 3)
    assert slurm.submitted(script, tmp_path).returncode == 0
    wait_for(lambda: len(list(out.glob("n.*.exr"))) > 5 * turn)
    slurm.kill("slurmd")
    slurm.run("slurmd", "-D", "-N", "here")
    slurm.drained()
    assert slurm.submitted(script, tmp_path).returncode == 0
    slurm.drained()
    assert files_in(out) == files_in(tmp_path / "whole")


@REAL
def test_a_job_that_no_node_can_run_takes_its_frames_back(capsys, shot_file, tmp_path, slurm):
    """The frames of the first array were taken already when the second is refused."""
    steps = (Step("Export", (("kits", FRAMES),), ("1",) * 1001),)
    job = FarmJob("n", (), steps, None, Needs(1, 1), ())
    script = slurm_script(job).replace("--array=0-0", "--array=0-0 --mem=900G")
    run = slurm.submitted(script, tmp_path)
    assert run.returncode == 2 and "Nothing is left" in run.stderr
    slurm.drained()


@REAL
def test_a_dead_controller_is_told(capsys, shot_file, tmp_path, slurm):
    script = script_of(capsys, shot_file, "-o", tmp_path / "n.####.exr", "--chunk", 2)
    slurm.kill("slurmctld")
    run = slurm.submitted(script, tmp_path)
    slurm.kill("slurmd")  # it makes itself known to a controller when it starts
    slurm.begin()
    assert run.returncode == 2 and run.stdout == ""
    assert run.stderr.splitlines()[-1].startswith("heatlens: Slurm did not take the job")


def test_a_machine_without_slurm_says_so(capsys, shot_file, tmp_path):
    script = script_of(capsys, shot_file, "-o", tmp_path / "n.####.exr", "--chunk", 2)
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "sh").symlink_to("/bin/sh")
    run = subprocess.run(
        ["/bin/sh"], input=script, capture_output=True, text=True, env={"PATH": str(tmp_path)},
        check=False,
    )  # fmt: skip
    assert run.returncode == 2 and run.stdout == ""
    assert re.fullmatch(r"heatlens: sbatch is not here.*\n", run.stderr)


def test_ten_thousand_frames_are_ten_arrays_in_a_short_text():
    place = Place("Out", Path("/x/out"), "DIRECTORY", "OUT")
    words = (("export",), ("--output=", place, "/n.exr"), ("--part=", FRAMES))
    parts = tuple(map(str, range(1001, 11_001)))
    steps, last = (Step("Export", words, parts),), Step("Join", words[:-1])
    script = slurm_script(FarmJob("n", (place,), steps, last, Needs(2, 2, 1), ()))
    assert len(script) < 1_000_000
    assert re.findall(r"--array=(\S+)", script) == ["0-999"] * 10
    told = [text for line in re.findall(r"^set -- (.*)$", script, re.M) for text in line.split()]
    assert told == list(parts)
    assert "--cpus-per-task=2 --mem=2G --gres=gpu:1" in script
