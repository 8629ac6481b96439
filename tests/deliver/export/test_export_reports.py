"""Test the machine-readable progress of an export for programs and render farms."""

import json
import re
from pathlib import Path

from heatlens.fronts.commands.main import main


def test_json_progress_prints_one_event_per_frame(capsys, shot_file, out):
    assert main(["export", str(shot_file), "-o", str(out), "--frames", "1001-1002"]) == 0
    capsys.readouterr()
    words = ["--frames", "1001-1004", "--progress", "json"]
    assert main(["export", str(shot_file), "-o", str(out), *words]) == 0
    captured = capsys.readouterr()
    begin, *frames, end = (json.loads(line) for line in captured.out.splitlines())
    assert begin == {"event": "begin", "output": str(out), "frames": 4}
    assert [(f["frame"], f["state"], f["done"]) for f in frames] == [
        (1001, "finished before", 1),
        (1002, "finished before", 2),
        (1003, "written", 3),
        (1004, "written", 4),
    ]
    assert frames[2]["path"] == str(out.parent / "n.1003.exr")
    assert frames[0]["seconds_left"] is None and frames[3]["seconds_left"] == 0
    assert end == {"event": "end", "output": str(out), "written": 2, "finished_before": 2}
    assert captured.err == ""


def damage(path: Path) -> None:
    """Damage pixels of a file but keep its length, so that only reading the frame finds it."""
    whole = path.read_bytes()
    half = len(whole) // 2
    path.write_bytes(whole[:half] + bytes(64) + whole[half + 64 :])


def test_openjd_progress_prints_status_progress_and_failure(capsys, shot_file, out, tmp_path):
    damage(tmp_path / "plates" / "plate.1002.exr")
    words = ["export", str(shot_file), "-o", str(out), "--progress", "openjd"]
    assert main(words) == 2
    lines = capsys.readouterr().out.splitlines()
    assert lines[:2] == ["openjd_status: frame 1001, 1 of 6", "openjd_progress: 16.7"]
    assert re.fullmatch(r"openjd_fail: .*plate\.1002\.exr.*damaged or cut short.*", lines[2])


def test_json_progress_ends_with_failure_message(capsys, shot_file, out, tmp_path):
    """The failure is also printed if it happens before the first frame."""
    words = ["export", str(shot_file), "-o", str(out), "--progress", "json"]
    damage(tmp_path / "plates" / "plate.1002.exr")
    assert main(words) == 2
    begin, frame, failed = (json.loads(line) for line in capsys.readouterr().out.splitlines())
    assert (begin["event"], frame["event"], failed["event"]) == ("begin", "frame", "failed")
    assert "plate.1002.exr" in failed["message"]
    assert main([*words, "--frames", "7"]) == 2
    (line,) = capsys.readouterr().out.splitlines()
    assert json.loads(line)["event"] == "failed"
