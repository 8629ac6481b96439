"""An export that is stopped in any way never leaves half a frame, and goes on where it was."""

import os
import random
import resource
import signal
import subprocess
import time
from pathlib import Path

import pytest

from heatlens.core.base.errors import InputError
from heatlens.deliver.export import frame_files
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.media.files.atomic_file import replacing
from support.command_line import started
from support.exports import (
    MANY,
    exported,
    files_in,
    names_of,
    refused,
    shot_of,
    with_focus,
    write_plates,
    written,
)

KILLS = 6


@pytest.fixture(scope="module")
def long_shot(tmp_path_factory) -> tuple[Path, dict[str, bytes]]:
    """Return a shot of many frames, and the files of its undisturbed export."""
    folder = tmp_path_factory.mktemp("long")
    path = folder / "s.heatlens.json"
    write_shot(path, shot_of(write_plates(folder / "plates", MANY), MANY))
    assert run_apart(path, folder / "whole" / "n.####.exr") == 0
    return path, files_in(folder / "whole")


def run_apart(shot_file, out, *words: object) -> int:
    """Export in a process of its own; the exit code."""
    process = started("export", shot_file, "-o", out, *words)
    said, complained = process.communicate(timeout=60)
    assert "Traceback" not in said + complained
    return process.returncode


def interrupted(shot_file, out, lines: int, wait_s: float, how: signal.Signals):
    """Export until `lines` lines of progress are out and then a file is begun, or time is over."""
    process = started("export", shot_file, "-o", out, "--progress", "json")
    for _ in range(lines):
        process.stdout.readline()
    end_s = time.monotonic() + wait_s
    while time.monotonic() < end_s and not parts_in(out.parent):
        pass
    process.send_signal(how)
    process.said = process.communicate(timeout=60)
    return process


def parts_in(folder: Path) -> list[str]:
    return [name for name in os.listdir(folder) if name.endswith(".part")]


def test_killed_again_and_again_and_resumed_it_is_as_if_nothing_had_been(long_shot, tmp_path):
    shot_file, whole = long_shot
    out = tmp_path / "n.####.exr"
    rng = random.Random(20060106)
    codes = []
    for _ in range(KILLS):
        kept = len([name for name in files_in(tmp_path) if name.endswith(".exr")])
        # The line of the beginning, those of frames that are there, and the next few.
        lines = min(1 + kept + rng.randrange(3), len(MANY) - 2)
        process = interrupted(shot_file, out, lines, rng.choice((0.0, 0.02)), signal.SIGKILL)
        codes.append(process.returncode)
        done = {name: data for name, data in files_in(tmp_path).items() if name.endswith(".exr")}
        assert all(whole[name] == data for name, data in done.items())
    assert set(codes) <= {0, -signal.SIGKILL} and codes.count(0) < KILLS // 2
    assert run_apart(shot_file, out) == 0
    assert files_in(tmp_path) == whole


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_ends_with_130_and_whole_frames_alone(long_shot, tmp_path, how):
    """Farms and windows send the other signal."""
    shot_file, whole = long_shot
    process = interrupted(shot_file, tmp_path / "n.####.exr", 4, 0.02, how)
    assert process.returncode == 128 + how
    assert process.said[1] == "heatlens: stopped\n"
    done = files_in(tmp_path)
    assert 3 <= len(done) < len(MANY)
    assert all(whole[name] == data for name, data in done.items())


def test_two_exports_into_one_folder_both_end_well(long_shot, tmp_path):
    shot_file, whole = long_shot
    words = ("export", shot_file, "-o", tmp_path / "n.####.exr")
    both = [started(*words) for _ in range(2)]
    assert [process.communicate(timeout=60)[1].count("\n") for process in both] == [1, 1]
    assert [process.returncode for process in both] == [0, 0]
    assert files_in(tmp_path) == whole


def test_chunks_in_processes_of_their_own_give_the_same_bytes(long_shot, tmp_path):
    shot_file, whole = long_shot
    out = tmp_path / "n.####.exr"
    words = ("export", shot_file, "-o", out, "--frames")
    both = [started(*words, chunk) for chunk in ("1001-1012", "1013-1024")]
    assert [process.communicate(timeout=60)[0] for process in both] == [f"{out}\n"] * 2
    assert files_in(tmp_path) == whole


def test_a_disk_that_fills_up_leaves_no_frame_cut_short(long_shot, tmp_path):
    """Under a limit of file size below that of any frame, as EFBIG and ENOSPC fail alike."""
    shot_file, whole = long_shot
    limit = min(map(len, whole.values())) - 100
    process = started(
        *("export", shot_file, "-o", tmp_path / "n.####.exr"),
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)),
    )
    said = process.communicate(timeout=60)[1]
    assert process.returncode == 2
    assert "n.1001.exr could not" in said and len(said.splitlines()) == 1
    assert files_in(tmp_path) == {}


def test_a_write_that_fails_in_the_middle_keeps_what_was_there(capsys, shot_file, out, monkeypatch):
    exported(capsys, shot_file, out)
    before = files_in(out.parent)
    write_shot(shot_file, with_focus(read_shot(shot_file), 1001, 1.3))
    write = frame_files.write_picture

    def full_from_1003(path, *args, **options):
        if "1003" in path.name:
            raise InputError(f"{path} could not be written: No space left on device")
        write(path, *args, **options)

    monkeypatch.setattr(frame_files, "write_picture", full_from_1003)
    assert "n.1003.exr" in refused(capsys, shot_file, out)
    after = files_in(out.parent)
    assert list(after) == names_of(".exr")
    assert after["n.1003.exr"] == before["n.1003.exr"]
    assert all(after[name] != before[name] for name in names_of(".exr", (1001, 1002)))
    monkeypatch.undo()
    assert written(capsys, shot_file, out)[0] == 1003


def test_leftovers_of_killed_exports_go_and_those_of_the_living_stay(capsys, shot_file, out):
    exported(capsys, shot_file, out, "--frames", "1001")
    dead = subprocess.Popen(["true"])
    dead.wait()
    with replacing(out.parent / "n.1001.exr") as beside:
        beside.write_bytes(b"x")
        machine = beside.name.split(".")[-3]  # .heatlens-RANDOM.MACHINE.PROCESS.part
    old, name = time.time() - 2 * 24 * 3600, ".heatlens-0123456789abcdef"
    gone = [f"{name}.{machine}.{dead.pid}.part", f"{name}.0badcafe.7.part"]
    stay = [
        f"{name}.{machine}.{os.getppid()}.part",  # of one that is alive
        f"{name}.0badcafe.8.part",  # of another machine, a moment ago
        f".n.1002.exr.{machine}.{dead.pid}.part",  # not ours
        f"{name}.{dead.pid}.part",
    ]
    for name in gone + stay:
        (out.parent / name).write_bytes(b"half")
    os.utime(out.parent / gone[1], (old, old))
    exported(capsys, shot_file, out, "--frames", "1001")
    assert set(files_in(out.parent)) == {"n.1001.exr", *stay}
