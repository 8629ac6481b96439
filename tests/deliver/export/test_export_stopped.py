"""Test that a stopped export never leaves half a frame and resumes where it stopped."""

import os
import random
import signal
import subprocess
import time
from pathlib import Path

import pytest

from heatlens.core.base.errors import InputError
from heatlens.deliver.export import frame_files
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.media.files.atomic_file import replace_atomically
from support.command_line import start_heatlens, start_heatlens_on_full_disk
from support.exports import (
    MANY_FRAMES,
    export_and_list_new_frames,
    export_shot,
    files_in,
    names_of,
    refused_export_message,
    shot_of,
    with_focus,
    write_plates,
)
from support.patience import PATIENCE_S

KILLS = 6


@pytest.fixture(scope="module")
def long_shot(tmp_path_factory) -> tuple[Path, dict[str, bytes]]:
    """Return a shot of many frames, and the files of its undisturbed export."""
    folder = tmp_path_factory.mktemp("long")
    path = folder / "s.heatlens.json"
    write_shot(path, shot_of(write_plates(folder / "plates", MANY_FRAMES), MANY_FRAMES))
    assert export_in_process(path, folder / "whole" / "n.####.exr") == 0
    return path, files_in(folder / "whole")


def export_in_process(shot_file, out, *words: object) -> int:
    """Export in a process of its own. Return its exit code."""
    process = start_heatlens("export", shot_file, "-o", out, *words)
    output, errors = process.communicate(timeout=PATIENCE_S)
    assert "Traceback" not in output + errors
    return process.returncode


def start_and_interrupt(shot_file, out, lines: int, wait_s: float, stop_signal: signal.Signals):
    """Send `stop_signal` to an export after `lines` lines of progress and the start of a file.

    After `wait_s` seconds the signal is sent even if no file was started. Return the process.
    """
    process = start_heatlens("export", shot_file, "-o", out, "--progress", "json")
    for _ in range(lines):
        process.stdout.readline()
    end_s = time.monotonic() + wait_s
    while time.monotonic() < end_s and not parts_in(out.parent):
        pass
    process.send_signal(stop_signal)
    process.said = process.communicate(timeout=PATIENCE_S)
    return process


def parts_in(folder: Path) -> list[str]:
    return [name for name in os.listdir(folder) if name.endswith(".part")]


def test_export_killed_repeatedly_and_resumed_gives_same_files(long_shot, tmp_path):
    shot_file, expected_files = long_shot
    out = tmp_path / "n.####.exr"
    rng = random.Random(20060106)
    codes = []
    for _ in range(KILLS):
        finished_count = len([name for name in files_in(tmp_path) if name.endswith(".exr")])
        # The line of the beginning, those of frames that are there, and the next few.
        lines = min(1 + finished_count + rng.randrange(3), len(MANY_FRAMES) - 2)
        process = start_and_interrupt(
            shot_file, out, lines, rng.choice((0.0, 0.02)), signal.SIGKILL
        )
        codes.append(process.returncode)
        finished_files = {
            name: data for name, data in files_in(tmp_path).items() if name.endswith(".exr")
        }
        assert all(expected_files[name] == data for name, data in finished_files.items())
    assert set(codes) <= {0, -signal.SIGKILL} and codes.count(0) < KILLS // 2
    assert export_in_process(shot_file, out) == 0
    assert files_in(tmp_path) == expected_files


@pytest.mark.parametrize("stop_signal", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_export_exits_with_128_plus_signal_and_whole_frames(
    long_shot, tmp_path, stop_signal
):
    """Ctrl-C sends SIGINT; farms and the window send SIGTERM."""
    shot_file, expected_files = long_shot
    process = start_and_interrupt(shot_file, tmp_path / "n.####.exr", 4, 0.02, stop_signal)
    assert process.returncode == 128 + stop_signal
    assert process.said[1] == "heatlens: stopped\n"
    finished_files = files_in(tmp_path)
    assert 3 <= len(finished_files) < len(MANY_FRAMES)
    assert all(expected_files[name] == data for name, data in finished_files.items())


def test_two_exports_into_one_folder_both_succeed(long_shot, tmp_path):
    shot_file, whole = long_shot
    words = ("export", shot_file, "-o", tmp_path / "n.####.exr")
    processes = [start_heatlens(*words) for _ in range(2)]
    messages = [process.communicate(timeout=PATIENCE_S)[1] for process in processes]
    assert [message.count("\n") for message in messages] == [1, 1]
    assert [process.returncode for process in processes] == [0, 0]
    assert files_in(tmp_path) == whole


def test_chunks_in_separate_processes_give_same_files(long_shot, tmp_path):
    shot_file, whole = long_shot
    out = tmp_path / "n.####.exr"
    words = ("export", shot_file, "-o", out, "--frames")
    processes = [start_heatlens(*words, chunk) for chunk in ("1001-1012", "1013-1024")]
    assert [process.communicate(timeout=PATIENCE_S)[0] for process in processes] == [f"{out}\n"] * 2
    assert files_in(tmp_path) == whole


def test_full_disk_leaves_no_truncated_frame(long_shot, tmp_path):
    """The limit of the size of a file is below that of any frame."""
    shot_file, expected_files = long_shot
    limit = min(map(len, expected_files.values())) - 100
    process = start_heatlens_on_full_disk(limit, "export", shot_file, "-o", tmp_path / "n.####.exr")
    message = process.communicate(timeout=PATIENCE_S)[1]
    assert process.returncode == 2
    assert "n.1001.exr could not" in message and len(message.splitlines()) == 1
    assert files_in(tmp_path) == {}


def test_failed_write_keeps_previous_frame(capsys, shot_file, out, monkeypatch):
    export_shot(capsys, shot_file, out)
    files_before = files_in(out.parent)
    write_shot(shot_file, with_focus(read_shot(shot_file), 1001, 1.3))
    write = frame_files.write_picture

    def full_from_1003(path, *args, **options):
        if "1003" in path.name:
            raise InputError(f"{path} could not be written: No space left on device")
        write(path, *args, **options)

    monkeypatch.setattr(frame_files, "write_picture", full_from_1003)
    assert "n.1003.exr" in refused_export_message(capsys, shot_file, out)
    files_after = files_in(out.parent)
    assert list(files_after) == names_of(".exr")
    assert files_after["n.1003.exr"] == files_before["n.1003.exr"]
    assert all(files_after[name] != files_before[name] for name in names_of(".exr", (1001, 1002)))
    monkeypatch.undo()
    assert export_and_list_new_frames(capsys, shot_file, out)[0] == 1003


def test_export_removes_temporary_files_of_dead_processes_only(capsys, shot_file, out):
    export_shot(capsys, shot_file, out, "--frames", "1001")
    dead = subprocess.Popen(["true"])
    dead.wait()
    with replace_atomically(out.parent / "n.1001.exr") as temporary_path:
        temporary_path.write_bytes(b"x")
        machine = temporary_path.name.split(".")[-3]  # .heatlens-RANDOM.MACHINE.PROCESS.part
    old_time_s, name = time.time() - 2 * 24 * 3600, ".heatlens-0123456789abcdef"
    removed_names = [f"{name}.{machine}.{dead.pid}.part", f"{name}.0badcafe.7.part"]
    kept_names = [
        f"{name}.{machine}.{os.getppid()}.part",  # of one that is alive
        f"{name}.0badcafe.8.part",  # of another machine, a moment ago
        f".n.1002.exr.{machine}.{dead.pid}.part",  # not ours
        f"{name}.{dead.pid}.part",
    ]
    for name in removed_names + kept_names:
        (out.parent / name).write_bytes(b"half")
    os.utime(out.parent / removed_names[1], (old_time_s, old_time_s))
    export_shot(capsys, shot_file, out, "--frames", "1001")
    assert set(files_in(out.parent)) == {"n.1001.exr", *kept_names}
