"""An export that is stopped in any way goes on where it was, and never leaves half a frame."""

import os
import random
import resource
import signal
import subprocess
import threading
import time
import weakref
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from command_line import started
from exports import (
    FRAMES,
    QUICK,
    exported,
    files_in,
    names_of,
    refused,
    shot_of,
    with_focus,
    write_plate,
    write_plates,
    write_shot_file,
)
from heatlens.commands import export as export_command
from heatlens.commands.main import main
from heatlens.errors import InputError
from heatlens.export import frame_files
from heatlens.export.fingerprint import fingerprint_of
from heatlens.export.frame_source import Origin
from heatlens.export.frame_writer import FrameWriter
from heatlens.export.job import ExportJob, ExrOptions, Look
from heatlens.export.output import parse_output
from heatlens.image.atomic_file import replacing
from heatlens.image.shot_file import read_shot, write_shot
from heatlens.model.lens import Lens
from heatlens.model.plate_options import PlateOptions
from heatlens.model.settings import Quality
from heatlens.model.shot import LensParameter

pytestmark = pytest.mark.usefixtures("command_context")
MANY = tuple(range(1001, 1025))
KILLS = 12


@pytest.fixture
def shot_file(tmp_path):
    return write_shot_file(tmp_path)


@pytest.fixture
def out(tmp_path):
    return tmp_path / "out" / "n.####.exr"


def written(capsys, shot_file, out, *words: object) -> list[int]:
    """Export once more; which frames were made anew."""
    before = {path: path.stat().st_ino for path in out.parent.glob("*")}
    exported(capsys, shot_file, out, *words)
    anew = [path for path in out.parent.glob("*") if before.get(path) != path.stat().st_ino]
    return sorted(int(path.name.split(".")[1]) for path in anew)


# What is finished


@pytest.mark.parametrize("suffix", [".exr", ".png", ".jpg"])
def test_what_is_finished_is_left(capsys, shot_file, tmp_path, suffix):
    out = tmp_path / "out" / f"n.####{suffix}"
    assert written(capsys, shot_file, out) == list(FRAMES)
    assert written(capsys, shot_file, out) == []
    assert written(capsys, shot_file, out, "--force", "--frames", "1002-1003") == [1002, 1003]


def test_nothing_left_to_do_needs_no_opengl(capsys, shot_file, out, monkeypatch):
    exported(capsys, shot_file, out)

    def none_here():
        raise AssertionError("a context was made")

    monkeypatch.setattr(export_command, "headless_context", none_here)
    assert "6 were finished before" in exported(capsys, shot_file, out)


def test_another_key_renders_the_frames_whose_lens_it_changes(capsys, shot_file, out):
    exported(capsys, shot_file, out)
    shot = read_shot(shot_file)
    changed = with_focus(shot, 1003, 1.5)
    write_shot(shot_file, changed)
    assert written(capsys, shot_file, out) == [1002, 1003, 1004, 1005]
    further = with_focus(changed, 1002, 1.1)
    write_shot(shot_file, further)
    differ = [f for f in FRAMES if changed.lens_at(f) != further.lens_at(f)]
    assert written(capsys, shot_file, out) == differ == [1002]


def test_a_plate_that_was_rendered_again_is_exported_again(capsys, shot_file, out, tmp_path):
    exported(capsys, shot_file, out)
    write_plate(tmp_path / "plates" / "plate.1005.exr", 3, owner="again")
    assert written(capsys, shot_file, out) == [1005]


def test_marks_close_focus_and_the_place_of_the_plates_change_no_pixel(
    capsys, shot_file, out, tmp_path
):
    exported(capsys, shot_file, out)
    shot = read_shot(shot_file)
    (tmp_path / "plates").rename(tmp_path / "elsewhere")
    moved = str(tmp_path / "elsewhere" / "plate.####.exr")
    lens = replace(shot.lens, close_focus_m=0.5, acceptable_coc_mm=0.02)
    write_shot(shot_file, replace(shot, lens=lens, source=moved, frames_per_second=25.0))
    assert written(capsys, shot_file, out) == []


def test_a_frame_of_somebody_else_is_not_taken_for_ours(capsys, shot_file, out, tmp_path):
    exported(capsys, shot_file, out)
    frame = out.parent / "n.1003.exr"
    ours = frame.read_bytes()
    for theirs in ((tmp_path / "plates" / "plate.1003.exr").read_bytes(), b"", ours[:40]):
        frame.unlink()
        frame.write_bytes(theirs)
        assert written(capsys, shot_file, out) == [1003]
        assert frame.read_bytes() == ours


def test_what_is_made_of_an_exported_frame_is_no_exported_frame(capsys, shot_file, out, tmp_path):
    """The fingerprint goes into the header, and must not go on from there."""
    exported(capsys, shot_file, out, "--with-depth")
    copy = tmp_path / "graded.exr"
    words = ["--bokeh", "heat", "--quality", "draft"]
    assert main(["render", str(out.parent / "n.1003.exr"), "-o", str(copy), *words]) == 0
    capsys.readouterr()
    copy.replace(out.parent / "n.1003.exr")
    assert written(capsys, shot_file, out, "--with-depth") == [1003]


JOB = ExportJob(shot_of("plate.####.exr"), FRAMES, parse_output("n.####.exr"))
LENS = Lens(50.0, 2.0, 2.0, 36.0)
PICTURES = replace(JOB, output=parse_output("n.####.png"))


def fingerprint(job=JOB, frame=1001, lens=LENS, stamp=(5, 6), is_black=False) -> str:
    return fingerprint_of(job, frame, lens, Origin(frame, is_black, None, stamp))


@pytest.mark.parametrize(
    "other",
    [
        {"frame": 1002},
        {"stamp": (5, 7)},
        {"stamp": (4, 6)},
        {"is_black": True},
        *(
            {"lens": replace(LENS, **{str(p): 1.9})}
            for p in LensParameter
            if p != "focal_length_mm"
        ),
        {"lens": replace(LENS, focal_length_mm=49.0)},
        {"lens": replace(LENS, sensor_width_mm=24.0)},
        {"lens": replace(LENS, focus_distance_m=float("inf"))},
        {"job": replace(JOB, exr=ExrOptions(half=False))},
        {"job": replace(JOB, exr=ExrOptions(compression="piz"))},
        {"job": replace(JOB, exr=ExrOptions(with_depth=True))},
        {"job": replace(JOB, exr=ExrOptions(with_coc=True))},
        {"job": replace(JOB, shot=replace(JOB.shot, defocus=replace(QUICK, layers=3)))},
        {"job": replace(JOB, shot=replace(JOB.shot, defocus=replace(QUICK, proxy=0.5)))},
        {"job": replace(JOB, shot=replace(JOB.shot, defocus=replace(QUICK, quality=Quality.FILM)))},
        {"job": replace(JOB, shot=replace(JOB.shot, plate_options=PlateOptions(near_m=1.0)))},
        {"job": PICTURES},
        {"job": replace(PICTURES, look=Look(exposure_stops=1.0))},
        {"job": replace(PICTURES, look=Look(burn_in=True))},
        {"job": replace(PICTURES, look=Look(burn_in=True, unit="ft"))},
        {"job": replace(PICTURES, output=parse_output("n.####.jpg"))},
    ],
)
def test_each_thing_that_decides_a_pixel_is_in_the_fingerprint(other):
    assert fingerprint(**other) != fingerprint()


@given(st.sampled_from(["hold", "black", "stop"]), st.booleans(), st.floats(1, 100))
@settings(deadline=None)
def test_what_decides_no_pixel_is_not(missing, force, rate):
    shot = replace(JOB.shot, frames_per_second=rate, source="/elsewhere/plate.####.exr")
    other = replace(JOB, shot=shot, frames=(1001,), missing=missing, force=force)
    assert fingerprint(other) == fingerprint()
    assert fingerprint(replace(JOB, look=Look(exposure_stops=2.0))) == fingerprint()
    assert fingerprint(replace(PICTURES, exr=ExrOptions(half=False))) == fingerprint(PICTURES)


# Stopped


@pytest.fixture(scope="module")
def long_shot(tmp_path_factory) -> tuple[Path, dict[str, bytes]]:
    """A shot of many frames, and the files of its undisturbed export."""
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


def test_killed_a_dozen_times_and_resumed_it_is_as_if_nothing_had_been(long_shot, tmp_path):
    shot_file, whole = long_shot
    out = tmp_path / "n.####.exr"
    rng = random.Random(20060106)
    codes, halves = [], 0
    for _ in range(KILLS):
        kept = len([name for name in files_in(tmp_path) if name.endswith(".exr")])
        # The line of the beginning, those of frames that are there, and the next few.
        lines = min(1 + kept + rng.randrange(3), len(MANY) - 2)
        process = interrupted(shot_file, out, lines, rng.choice((0.0, 0.02)), signal.SIGKILL)
        codes.append(process.returncode)
        halves += len(parts_in(tmp_path))
        done = {name: data for name, data in files_in(tmp_path).items() if name.endswith(".exr")}
        assert all(whole[name] == data for name, data in done.items())
    assert set(codes) <= {0, -signal.SIGKILL} and codes.count(0) < KILLS // 2 and halves > 0
    assert run_apart(shot_file, out) == 0
    assert files_in(tmp_path) == whole


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_ends_with_130_and_whole_frames_alone(long_shot, tmp_path, how):
    """Farms and windows send the other signal."""
    shot_file, whole = long_shot
    process = interrupted(shot_file, tmp_path / "n.####.exr", 4, 0.02, how)
    assert process.returncode == 130
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
    assert "n.1001.exr could not be written" in said and len(said.splitlines()) == 1
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
    with replacing(out.parent / "n.1001.exr") as beside:  # .n.1001.exr.MACHINE.PROCESS.part
        beside.write_bytes(b"")
        machine = beside.name.split(".")[-3]
    old = time.time() - 2 * 24 * 3600
    gone = [f".n.1002.exr.{machine}.{dead.pid}.part", ".n.1003.exr.0badcafe.7.part"]
    stay = [
        f".n.1002.exr.{machine}.{os.getppid()}.part",  # of one that is alive
        ".n.1004.exr.0badcafe.7.part",  # of another machine, a moment ago
        f".other.1002.exr.{machine}.{dead.pid}.part",  # not ours
        f".n.1002.exr.{dead.pid}.part",
    ]
    for name in gone + stay:
        (out.parent / name).write_bytes(b"half")
    os.utime(out.parent / gone[1], (old, old))
    exported(capsys, shot_file, out, "--frames", "1001")
    assert set(files_in(out.parent)) == {"n.1001.exr", *stay}


# Reading, rendering and writing at a time


def test_the_writer_keeps_the_order_and_no_more_than_it_may(rng):
    lock, waiting, most = threading.Lock(), 0, 0

    def one(number: int):
        def write() -> int:
            nonlocal waiting
            time.sleep(0.002)
            with lock:
                waiting -= 1
            return number

        return write

    found = []
    with FrameWriter[int]() as writer:
        for number in range(20):
            with lock:
                waiting += 1
                most = max(most, waiting)
            found += writer.put(one(number))
        found += writer.drain()
    assert found == list(range(20)) and waiting == 0
    assert 1 < most <= 4


def test_a_writer_left_by_an_error_drops_what_has_not_begun():
    begun, go_on, done = threading.Event(), threading.Event(), []

    def slow() -> int:
        begun.set()
        go_on.wait()
        done.append(0)
        return 0

    with pytest.raises(RuntimeError, match="stop"), FrameWriter[int]() as writer:
        list(writer.put(slow))
        list(writer.put(lambda: done.append(1) or 1))
        begun.wait()
        threading.Timer(0.05, go_on.set).start()
        raise RuntimeError("stop")
    assert done == [0]


def test_what_writing_raises_comes_out_of_the_next_step():
    def fail() -> int:
        raise InputError("full")

    with FrameWriter[int]() as writer:
        with pytest.raises(InputError, match="full"):
            list(writer.put(fail))
            list(writer.drain())


def test_frames_are_let_go_of_while_the_export_runs(capsys, tmp_path, monkeypatch):
    """However long the shot, a handful of rendered frames are in memory."""
    alive: list[weakref.ref] = []
    most = 0
    write = frame_files.write_picture

    def counted(path, pixels, *args, **options):
        nonlocal most
        alive.append(weakref.ref(pixels))
        most = max(most, sum(reference() is not None for reference in alive))
        write(path, pixels, *args, **options)

    monkeypatch.setattr(frame_files, "write_picture", counted)
    write_shot(tmp_path / "s.heatlens.json", shot_of(write_plates(tmp_path / "plates", MANY), MANY))
    exported(capsys, tmp_path / "s.heatlens.json", tmp_path / "n.####.exr")
    assert len(alive) == len(MANY) and most <= 4
