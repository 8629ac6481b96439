"""Test the script of `--submit slurm` on a real Slurm with one node."""

import re
import subprocess
from pathlib import Path

import pytest

from heatlens.deliver.farm.job import FRAMES, FarmJob, Needs, Place, Step
from heatlens.deliver.farm.slurm import slurm_script
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import write_shot
from support.exports import (
    MANY_FRAMES,
    export_shot,
    files_in,
    shot_of,
    write_plates,
    write_shot_file,
)
from support.slurm import Slurm, wait_for, why_no_slurm

REAL = pytest.mark.skipif(bool(why_no_slurm()), reason=why_no_slurm() or "a Slurm can be started")


@pytest.fixture(scope="module")
def slurm(tmp_path_factory):
    cluster = Slurm(tmp_path_factory.mktemp("slurm"))
    try:
        cluster.start()
        yield cluster
    finally:
        cluster.stop()


def script_of(capsys, *words: object) -> str:
    submit_options = ("--submit", "slurm", "--memory", "1", "--cpus", "1")
    assert main(["export", *map(str, words), *submit_options]) == 0
    return capsys.readouterr().out


def logs(folder: Path) -> str:
    return "".join(path.read_text() for path in folder.glob("slurm-*.out"))


@REAL
@pytest.mark.parametrize("output", ["n.####.exr", "m.mov"])
def test_slurm_job_gives_files_of_one_machine(capsys, shot_file, tmp_path, slurm, output):
    export_shot(capsys, shot_file, tmp_path / "whole" / output)
    script = script_of(capsys, shot_file, "-o", tmp_path / "out" / output, "--chunk", 2)
    run = slurm.submitted(script, tmp_path)
    assert run.returncode == 0, run.stderr
    assert len(run.stdout.split()) == (2 if output == "m.mov" else 1)
    slurm.drained()
    assert files_in(tmp_path / "out") == files_in(tmp_path / "whole"), logs(tmp_path)
    assert not list((tmp_path / "out").glob("*.frames"))


@REAL
def test_slurm_script_quotes_any_character(capsys, tmp_path, slurm):
    """The paths contain blanks, quotes, %, {{, dollar signs and line ends."""
    odd = tmp_path / "a 'b' \"c\" %j {{d}} $HOME `e`\nEND\n#"
    odd.mkdir()
    shot = write_shot_file(odd)
    words = ("--frames", "1001-1002", "--burn-in", "--burn-in-text", "F {frame} 'x' $y\nEND\nz")
    export_shot(capsys, shot, tmp_path / "whole" / "n.####.png", *words)
    script = script_of(capsys, shot, "-o", odd / "out" / "n.####.png", "--chunk", 1, *words)
    assert slurm.submitted(script, tmp_path).returncode == 0
    slurm.drained()
    assert files_in(odd / "out") == files_in(tmp_path / "whole"), logs(tmp_path)


@REAL
def test_slurm_job_joins_no_movie_after_failed_frame(capsys, shot_file, tmp_path, slurm):
    script = script_of(capsys, shot_file, "-o", tmp_path / "m.mov", "--chunk", 2)
    (tmp_path / "plates" / "plate.1003.exr").write_bytes(b"")
    assert slurm.submitted(script, tmp_path).returncode == 0
    slurm.drained()
    assert not (tmp_path / "m.mov").exists()
    assert "plate.1003.exr is empty" in logs(tmp_path)
    assert len(files_in(tmp_path / "m.mov.frames")) == 4


def write_many_frames_shot(folder: Path, frames: tuple[int, ...] = MANY_FRAMES) -> Path:
    shot = folder / "s.heatlens.json"
    write_shot(shot, shot_of(write_plates(folder / "plates", frames), frames))
    return shot


@REAL
@pytest.mark.parametrize("task_index", [0, 1])
def test_slurm_job_with_killed_task_can_be_submitted_again(capsys, tmp_path, slurm, task_index):
    """The task is killed as by a node without memory; finished frames stay unchanged."""
    shot, out = write_many_frames_shot(tmp_path), tmp_path / "out"
    export_shot(capsys, shot, tmp_path / "whole" / "n.####.exr", "--proxy", "1")
    script = script_of(capsys, shot, "-o", out / "n.####.exr", "--chunk", 12, "--proxy", "1")
    ids = slurm.submitted(script, tmp_path).stdout.split()
    wait_for(lambda: len(list(out.glob("n.*.exr"))) > 3 * task_index)
    slurm.said("scancel", "--signal=KILL", "--full", f"{ids[0]}_{task_index}")
    slurm.drained()
    inodes_before = {path: path.stat().st_ino for path in out.glob("n.*.exr")}
    assert slurm.submitted(script, tmp_path).returncode == 0
    slurm.drained()
    assert files_in(out) == files_in(tmp_path / "whole")
    assert all(path.stat().st_ino == inode for path, inode in inodes_before.items())


@REAL
@pytest.mark.parametrize("attempt", [0, 1])
def test_slurm_job_survives_death_of_node(capsys, tmp_path, slurm, attempt):
    """Slurm queues the tasks of a node that does not answer again."""
    shot, out = (
        write_many_frames_shot(tmp_path, MANY_FRAMES[:12]),
        tmp_path / "out",
    )  # two tasks run, and two wait
    export_shot(capsys, shot, tmp_path / "whole" / "n.####.exr")
    script = script_of(capsys, shot, "-o", out / "n.####.exr", "--chunk", 3)
    assert slurm.submitted(script, tmp_path).returncode == 0
    wait_for(lambda: len(list(out.glob("n.*.exr"))) > 5 * attempt)
    slurm.kill("slurmd")
    slurm.run("slurmd", "-D", "-N", "here")
    slurm.drained()
    assert slurm.submitted(script, tmp_path).returncode == 0
    slurm.drained()
    assert files_in(out) == files_in(tmp_path / "whole")


@REAL
def test_slurm_script_cancels_all_arrays_if_one_is_refused(capsys, shot_file, tmp_path, slurm):
    """The first array was already accepted when Slurm refuses the second one."""
    steps = (Step("Export", (("kits", FRAMES),), ("1",) * 1001),)
    job = FarmJob(name="n", places=(), steps=steps, last=None, needs=Needs(1, 1), inputs=())
    script = slurm_script(job).replace("--array=0-0", "--array=0-0 --mem=900G")
    run = slurm.submitted(script, tmp_path)
    assert run.returncode == 2 and "Nothing is left" in run.stderr
    slurm.drained()


@REAL
def test_slurm_script_reports_dead_controller(capsys, shot_file, tmp_path, slurm):
    script = script_of(capsys, shot_file, "-o", tmp_path / "n.####.exr", "--chunk", 2)
    slurm.kill("slurmctld")
    run = slurm.submitted(script, tmp_path)
    slurm.kill("slurmd")  # it makes itself known to a controller when it starts
    slurm.begin()
    assert run.returncode == 2 and run.stdout == ""
    assert run.stderr.splitlines()[-1].startswith("heatlens: Slurm did not take the job")


def test_slurm_script_reports_missing_sbatch(capsys, shot_file, tmp_path):
    script = script_of(capsys, shot_file, "-o", tmp_path / "n.####.exr", "--chunk", 2)
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "sh").symlink_to("/bin/sh")
    run = subprocess.run(
        ["/bin/sh"], input=script, capture_output=True, text=True, env={"PATH": str(tmp_path)},
        check=False,
    )  # fmt: skip
    assert run.returncode == 2 and run.stdout == ""
    assert re.fullmatch(r"heatlens: sbatch is not here.*\n", run.stderr)


def test_slurm_script_of_10_000_frames_has_ten_arrays():
    place = Place("Out", Path("/x/out"), "DIRECTORY", "OUT")
    words = (("export",), ("--output=", place, "/n.exr"), ("--part=", FRAMES))
    parts = tuple(map(str, range(1001, 11_001)))
    steps, join_step = (Step("Export", words, parts),), Step("Join", words[:-1])
    script = slurm_script(FarmJob("n", (place,), steps, join_step, Needs(2, 2, 1), ()))
    assert len(script) < 1_000_000
    assert re.findall(r"--array=(\S+)", script) == ["0-999"] * 10
    frames = [text for line in re.findall(r"^set -- (.*)$", script, re.M) for text in line.split()]
    assert frames == list(parts)
    assert "--cpus-per-task=2 --mem=2G --gres=gpu:1" in script
