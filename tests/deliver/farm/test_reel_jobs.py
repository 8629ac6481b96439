"""Test `--submit` of a reel or an edit: one job with all shots and the steps that follow them."""

import json
import os
from contextlib import nullcontext
from pathlib import Path

import opentimelineio as otio
import pytest
import yaml

from deliver.farm.test_bundle import QUICK, copy_listed_files, write_bundle
from deliver.farm.test_openjd import openjd
from deliver.farm.test_slurm import REAL, logs, script_of, slurm  # noqa: F401
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.reel import Reel, ReelShot
from heatlens.fronts.commands.main import main
from heatlens.media.documents.reel_file import write_reel
from heatlens.media.documents.shot_file import write_shot
from support.dask_cluster import dask_cluster
from support.exports import files_in, refused_export_message, shot_of, write_plates

LENS = ("--f-stop", "1.4", "--focus-distance", "2", "--quality", "draft")
CUT = (FrameRange(1002, 1003), FrameRange(1004, 1005))


def files_below(folder: Path) -> dict[str, bytes]:
    """Return name and content of every file below a folder."""
    paths = sorted(path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


@pytest.fixture
def reel(tmp_path) -> Path:
    """Write a reel of plates, an empty frame, and a shot file, in folders of their own."""
    show = tmp_path / "show"
    show.mkdir()
    (show / "shots").mkdir()
    shot = show / "shots" / "s2.heatlens.json"
    write_shot(shot, shot_of(write_plates(show / "two")))
    shots = (
        ReelShot(name="s1", source=write_plates(show / "one"), frames=CUT[0]),
        ReelShot(name="s2", source=str(shot), frames=CUT[1]),
    )
    write_reel(show / "cut.heatreel.json", Reel("cut", shots, 25.0, "01:00:00:00", ((1, 1),)))
    return show / "cut.heatreel.json"


def edit_of(folder: Path, source: str) -> Path:
    """Write an edit whose media have absolute paths."""
    track = otio.schema.Track(kind="Video")
    for name, cut in zip(("s1", "s2"), CUT, strict=True):
        source_range = [otio.opentime.RationalTime(value, 24) for value in (cut.first, cut.count)]
        media = otio.schema.ExternalReference(target_url=source.replace("####", "%04d"))
        clip = otio.schema.Clip(name, media, otio.opentime.TimeRange(*source_range))
        track.append(clip)
    timeline = otio.schema.Timeline("cut")
    timeline.tracks.append(track)
    otio.adapters.write_to_file(timeline, str(folder / "cut.otio"))
    return folder / "cut.otio"


def export(shot: Path, out: Path, *words: object) -> None:
    assert main(["export", str(shot), "-o", str(out), *map(str, words)]) == 0


def run_here(capsys, folder: Path, *words: object) -> list[dict]:
    """Run the job of an export as a bundle; return its steps."""
    write_bundle(capsys, folder / "job", *words)
    values = f"file://{folder / 'job' / 'parameters.json'}"
    run = openjd("run", folder / "job" / "template.yaml", "-p", values)
    assert run.returncode == 0, run.stdout
    return yaml.safe_load((folder / "job" / "template.yaml").read_text())["steps"]


def test_openjd_job_of_cut_joins_movie_in_last_step(capsys, tmp_path, reel):
    """The last step waits for the frames of all shots; its movie equals that of one machine."""
    export(reel, tmp_path / "whole" / "cut.mov", *LENS[4:])
    out = tmp_path / "new" / "cut.mov"
    *export_steps, join_step = run_here(capsys, tmp_path, reel, "-o", out, *LENS[4:])
    assert [step["name"] for step in export_steps] == ["Export 001 s1", "Export 002 s2"]
    assert [it["dependsOn"] for it in join_step["dependencies"]] == [
        step["name"] for step in export_steps
    ]
    assert files_below(tmp_path / "new") == files_below(tmp_path / "whole")


def test_openjd_job_of_reel_runs_command_for_each_shot(capsys, tmp_path, reel):
    """The `--after-export` command runs once for each shot with the shot's name in the reel."""
    words = (*LENS[4:], "--edit-out", tmp_path / "new" / "made.otio")
    report_path = tmp_path / "told"
    command = f"cat >> '{report_path}'"
    out = tmp_path / "new" / "{shot}" / "{shot}.####.exr"
    (tmp_path / "new").mkdir()
    run_here(capsys, tmp_path, reel, "-o", out, *words, "--after-export", command)
    assert [json.loads(line)["shot"] for line in report_path.read_text().splitlines()] == [
        "s1",
        "s2",
    ]
    (tmp_path / "new" / "made.otio").unlink()
    export(reel, tmp_path / "whole" / "{shot}" / "{shot}.####.exr", *LENS[4:])
    assert files_below(tmp_path / "new") == files_below(tmp_path / "whole")


@pytest.mark.parametrize("kind", ["reel", "edit"])
def test_bundle_of_cut_needs_only_listed_files(capsys, tmp_path, reel, kind):
    """The worker has other folders; the absolute paths in the edit do not exist there."""
    show = tmp_path / "show"
    cut = reel if kind == "reel" else edit_of(show, str(show / "one" / "plate.####.exr"))
    lens = LENS if kind == "edit" else LENS[4:]
    export(cut, tmp_path / "whole" / "cut.mov", *lens)
    values = write_bundle(capsys, tmp_path / "job", cut, "-o", tmp_path / "new" / "cut.mov", *lens)
    (tmp_path / "worker").mkdir()
    worker_paths = copy_listed_files(tmp_path / "job", values, tmp_path / "worker")
    os.rename(show, tmp_path / "gone")
    path_options = [
        word for name, value in worker_paths.items() for word in ("-p", f"{name}={value}")
    ]
    run = openjd("run", tmp_path / "job" / "template.yaml", *path_options)
    assert run.returncode == 0, run.stdout
    assert files_below(Path(worker_paths["Out"])) == files_below(tmp_path / "whole")


@REAL
def test_slurm_job_of_cut_gives_same_movie(capsys, tmp_path, reel, slurm):  # noqa: F811
    export(reel, tmp_path / "whole" / "cut.mov", *LENS[4:])
    capsys.readouterr()
    words = ("-o", tmp_path / "new" / "cut.mov", "--chunk", 1, *LENS[4:])
    run = slurm.submitted(script_of(capsys, reel, *words), tmp_path)
    assert len(run.stdout.split()) == 3, run.stderr
    slurm.drained()
    assert files_below(tmp_path / "new") == files_below(tmp_path / "whole"), logs(tmp_path)


def test_submit_refuses_reel_with_too_many_shots(capsys, tmp_path):
    source = write_plates(tmp_path / "p")
    shots = tuple(ReelShot(name=f"s{n}", source=source, frames=CUT[0]) for n in range(101))
    write_reel(tmp_path / "cut.heatreel.json", Reel("cut", shots))
    words = (*LENS, "--submit", "openjd", *QUICK)
    message = refused_export_message(
        capsys, tmp_path / "cut.heatreel.json", tmp_path / "{shot}.####.exr", *words
    )
    assert "101 shots" in message and "fewer shots" in message
    assert not files_in(tmp_path).keys() - {"cut.heatreel.json"}


def test_after_export_command_writes_pull_sheet_after_last_frame(capsys, tmp_path, reel):
    """As in the manual, the `--after-export` command is `heatlens shot sheet`."""
    shot, page = reel.parent / "shots" / "s2.heatlens.json", tmp_path / "pull.html"
    command = f"ls '{tmp_path}'/new/n.*.exr > '{tmp_path}/seen'; "
    command += f"heatlens shot sheet '{shot}' -o '{page}'"
    (tmp_path / "new").mkdir()
    run_here(
        capsys, tmp_path, shot, "-o", tmp_path / "new" / "n.####.exr", "--after-export", command
    )
    assert len((tmp_path / "seen").read_text().splitlines()) == 6
    assert page.read_text().count("<img") == 2 and page.with_suffix(".csv").exists()


@pytest.mark.parametrize("renderer_kind", ["processes", "cluster"])
def test_processes_and_cluster_render_movie_of_cut(tmp_path, reel, renderer_kind):
    """The movie equals that of one process, and no other files remain."""
    export(reel, tmp_path / "whole" / "cut.mov", *LENS[4:])
    with (
        dask_cluster(tmp_path / "cluster", workers=1)
        if renderer_kind == "cluster"
        else nullcontext() as cluster
    ):
        words = ("--processes", 2) if cluster is None else ("--cluster", cluster.address)
        export(reel, tmp_path / "new" / "cut.mov", *LENS[4:], *words)
    assert files_below(tmp_path / "new") == files_below(tmp_path / "whole")
