"""Processes that print what they like: their events arrive, and results stay whole."""

import json
import subprocess
from pathlib import Path

import pytest

from heatlens.deliver.farm.events import event_in
from support.dask_cluster import HEATLENS
from support.exports import exported, files_in

# Python imports this module at its start; each renamed file then prints, as a driver might.
NOISE = """
import ctypes, os, sys
_replace, _library = os.replace, ctypes.CDLL(None)
def noisy(*words, **named):
    os.write(1, b'{"event": "frame", "frame": 99999, "state": "written"}\\n')
    os.write(1, b"x" * AMOUNT + b"\\n")
    _library.printf(b"%s\\n", b"[1, 2]" + b"y" * AMOUNT)
    _library.fflush(None)
    print("[1]", '{"a": 2}', "z" * AMOUNT, "null", sep="\\n", flush=True)
    return _replace(*words, **named)
os.replace = os.rename = noisy
"""


@pytest.fixture(params=[200, 2**20])
def noisy(request, tmp_path, monkeypatch) -> int:
    """Let all processes that are started print this many bytes for each file."""
    (tmp_path / "site").mkdir()
    words = NOISE.replace("AMOUNT", str(request.param))
    (tmp_path / "site" / "sitecustomize.py").write_text(words)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "site"))
    return int(request.param)


def test_frames_of_processes_that_print_are_those_of_quiet_ones(capsys, shot_file, tmp_path, noisy):
    exported(capsys, shot_file, tmp_path / "whole" / "n.####.exr")  # in this process, unchanged
    out = tmp_path / "out" / "n.####.exr"
    said = exported(capsys, shot_file, out, "--processes", 2)
    assert "6 frames written" in said
    assert files_in(tmp_path / "out") == files_in(tmp_path / "whole")


def test_a_job_is_measured_through_what_is_printed(shot_file, tmp_path, noisy):
    words = ("export", shot_file, "-o", tmp_path / "n.####.exr", "--submit", "openjd")
    done = subprocess.run(
        [*HEATLENS, *map(str, words)], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0 and "fault" not in done.stderr, done.stderr[-2000:]


def test_results_are_not_mixed_with_what_a_library_prints(shot_file, tmp_path, noisy):
    """What C and descriptors print goes to stderr; Python's own prints are nobody's to move."""
    words = ("export", shot_file, "-o", tmp_path / "n.####.exr", "--progress=json")
    done = subprocess.run([*HEATLENS, *map(str, words)], capture_output=True, timeout=120)
    assert done.returncode == 0
    assert b"xxx" not in done.stdout and b"yyy" not in done.stdout
    assert b"xxx" in done.stderr and b"yyy" in done.stderr
    events = [event for line in done.stdout.splitlines() if (event := event_in(line))]
    assert [event["event"] for event in events] == ["begin", *["frame"] * 6, "end"]
    assert 99999 not in [event.get("frame") for event in events]


NO_EVENTS = ("", "x", "1", "null", "[1]", '"end"', "{}", '{"event": 3}', '{"event": "x"}')


@pytest.mark.parametrize("line", [*NO_EVENTS, "[" * 9999])
def test_other_lines_are_no_events(line):
    assert event_in(line) is None
    assert event_in(line.encode()) is None


def test_events_are_read_as_they_were_printed():
    event = {"event": "frame", "frame": 3, "path": str(Path("a"))}
    assert event_in(json.dumps(event)) == event
