"""The folder without Python (`app/frozen/`), where HEATLENS_FROZEN names the program in it.

It runs with an empty environment and only the programs of the system, as where no Python is.
"""

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import opentimelineio as otio
import pytest
from opentimelineio.opentime import RationalTime, TimeRange

from heatlens.media.plate.exr.exr_read import read_parts
from support import x_server
from support.exports import FRAMES, write_plates

PROGRAM = os.environ.get("HEATLENS_FROZEN", "")
pytestmark = pytest.mark.skipif(not PROGRAM, reason="HEATLENS_FROZEN names no frozen program")
DEMO = ("demo", "--frames", "1-4", "--size", "160x90", "--quality", "draft")


@pytest.fixture
def run(tmp_path):
    """Run the program in a folder of its own; it must succeed. Return its standard output."""
    environment = {"HOME": str(tmp_path), "PATH": str(tmp_path / "bin")}
    (tmp_path / "bin").mkdir()

    def run_program(*words: object) -> str:
        process = subprocess.run(
            [PROGRAM, *map(str, words)],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        assert process.returncode == 0, process.stderr
        return process.stdout

    return run_program


def test_frozen_program_renders_like_the_installed_one(run, tmp_path):
    from heatlens.fronts.commands.main import main

    words = ("render", "demo", "--size", "160x90", "--frame", "5", "-o")
    run(*words, "frozen.exr")
    assert main([*words, str(tmp_path / "installed.exr")]) == 0
    frozen, installed = (
        read_parts(tmp_path / f"{name}.exr")[0][1]["R"] for name in ("frozen", "installed")
    )
    np.testing.assert_array_equal(frozen, installed)


def test_frozen_program_exports_movie(run, tmp_path):
    run("export", *DEMO, "-o", "demo.mp4")
    assert (tmp_path / "demo.mp4").read_bytes()[4:8] == b"ftyp"
    assert "4 frames" in run("info", "demo.mp4")


def test_frozen_program_exports_with_processes_and_runs_command_after(run, tmp_path):
    """The command runs with the libraries of the system, not with those of the folder."""
    command = '/bin/cat > facts.json; echo "[$LD_LIBRARY_PATH]" > libraries'
    run("export", *DEMO, "--processes", 2, "-o", "n.####.exr", "--after-export", command)
    assert len(json.loads((tmp_path / "facts.json").read_text())["files"]) == 4
    assert (tmp_path / "libraries").read_text() == "[]\n"
    assert len(list(tmp_path.glob("n.*.exr"))) == 4


def test_frozen_program_reads_aaf_and_scene_in_children(run, tmp_path):
    pattern = write_plates(tmp_path / "plates", FRAMES)
    reference = otio.schema.ExternalReference(
        Path(pattern).parent.joinpath("plate.1001.exr").as_uri(),
        TimeRange(RationalTime(0, 24), RationalTime(len(FRAMES), 24)),
    )
    part = TimeRange(RationalTime(1, 24), RationalTime(3, 24))
    track = otio.schema.Track(kind=otio.schema.TrackKind.Video)
    track.append(otio.schema.Clip("sh010", reference, part))
    timeline = otio.schema.Timeline("cut")
    timeline.tracks.append(track)
    otio.adapters.write_to_file(timeline, str(tmp_path / "cut.aaf"), use_empty_mob_ids=True)
    assert "sh010" in run("info", "cut.aaf")


def test_doctor_finds_no_fault_in_frozen_program(run):
    """It loads each part, builds every shader and starts two processes."""
    assert json.loads(run("doctor", "--json"))["ok"]


def test_frozen_window_opens_and_closes(tmp_path, monkeypatch):
    def start_frozen(*words: object, **options: object) -> "subprocess.Popen[str]":
        pipe = subprocess.PIPE
        return subprocess.Popen(
            [PROGRAM, *map(str, words)], text=True, stdout=pipe, stderr=pipe, **options
        )

    monkeypatch.setattr(x_server, "start_heatlens", start_frozen)
    screen = x_server.Screen()
    try:
        write_plates(tmp_path, FRAMES[:1])
        plate = tmp_path / f"plate.{FRAMES[0]}.exr"
        window = x_server.Window(screen, tmp_path, plate, "--quality", "draft")
        window.rest()
        assert np.asarray(screen.picture().convert("L")).std() > 10
        window.quit()
        assert window.closed() == (0, "")
    finally:
        screen.close()
