"""Test processes whose libraries print to stdout: events arrive, and results stay intact."""

import json
import subprocess
from pathlib import Path

import pytest

from heatlens.deliver.farm.events import event_in
from support.dask_cluster import HEATLENS
from support.exports import export_shot, files_in
from support.patience import PATIENCE_S

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
def noise_bytes(request, tmp_path, monkeypatch) -> int:
    """Make all started processes print many bytes for each renamed file. Return the number."""
    (tmp_path / "site").mkdir()
    words = NOISE.replace("AMOUNT", str(request.param))
    (tmp_path / "site" / "sitecustomize.py").write_text(words)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "site"))
    return int(request.param)


def test_export_with_printing_processes_gives_same_files(capsys, shot_file, tmp_path, noise_bytes):
    export_shot(capsys, shot_file, tmp_path / "whole" / "n.####.exr")  # in this process, unchanged
    out = tmp_path / "out" / "n.####.exr"
    message = export_shot(capsys, shot_file, out, "--processes", 2)
    assert "6 frames written" in message
    assert files_in(tmp_path / "out") == files_in(tmp_path / "whole")


def test_submit_measures_job_despite_printed_noise(shot_file, tmp_path, noise_bytes):
    words = ("export", shot_file, "-o", tmp_path / "n.####.exr", "--submit", "openjd")
    process = subprocess.run(
        [*HEATLENS, *map(str, words)],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )
    assert process.returncode == 0 and "fault" not in process.stderr, process.stderr[-2000:]


def test_json_progress_is_not_mixed_with_library_output(shot_file, tmp_path, noise_bytes):
    """Output of C code and of file descriptors goes to stderr; Python's prints stay on stdout."""
    words = ("export", shot_file, "-o", tmp_path / "n.####.exr", "--progress=json")
    process = subprocess.run([*HEATLENS, *map(str, words)], capture_output=True, timeout=PATIENCE_S)
    assert process.returncode == 0
    assert b"xxx" not in process.stdout and b"yyy" not in process.stdout
    assert b"xxx" in process.stderr and b"yyy" in process.stderr
    events = [event for line in process.stdout.splitlines() if (event := event_in(line))]
    assert [event["event"] for event in events] == ["begin", *["frame"] * 6, "end"]
    assert 99999 not in [event.get("frame") for event in events]


NO_EVENTS = ("", "x", "1", "null", "[1]", '"end"', "{}", '{"event": 3}', '{"event": "x"}')


@pytest.mark.parametrize("line", [*NO_EVENTS, "[" * 9999])
def test_event_in_returns_none_for_other_lines(line):
    assert event_in(line) is None
    assert event_in(line.encode()) is None


def test_event_in_reads_printed_event():
    event = {"event": "frame", "frame": 3, "path": str(Path("a"))}
    assert event_in(json.dumps(event)) == event
