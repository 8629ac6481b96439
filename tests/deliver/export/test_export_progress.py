"""How an export tells how far it is: a line on a terminal, nothing where nobody looks."""

import json
import os
import pty
import re
import select
import subprocess
from types import SimpleNamespace

import pytest

from heatlens.deliver.export.run import FrameDone
from heatlens.fronts.commands.output.export_progress import Tally, progress_of, progress_text
from support.command_line import started
from support.exports import write_shot_file


def done(frame: int, was_there: bool = False) -> FrameDone:
    return FrameDone(frame, None, was_there)


class Clock:
    """Seconds that pass when they are told to."""

    now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


def test_time_left_is_what_the_frames_so_far_took():
    clock = Clock()
    tally = Tally(10, clock)
    assert tally.left_s is None and progress_text(tally) == "0 of 10 done"
    for frame, now_s in ((1, 2.0), (2, 4.0), (3, 6.0)):
        clock.now_s = now_s
        tally.add(done(frame))
    assert tally.left_s == pytest.approx(7 * 2.0)
    assert progress_text(tally) == "3 of 10 done, 14 s left"


def test_frames_that_were_there_take_no_time_and_count():
    clock = Clock()
    tally = Tally(10, clock)
    for frame in range(6):
        clock.now_s += 0.1
        tally.add(done(frame, was_there=True))
    clock.now_s += 3.0
    tally.add(done(7))
    assert (tally.done, tally.kept, tally.written) == (7, 6, [7])
    assert tally.left_s == pytest.approx(3 * 3.0)


@pytest.mark.parametrize(
    ("frames", "pace_s", "expected"),
    [(10, 1.0, "9 s"), (100, 1.0, "99 s"), (100, 2.0, "3 min"), (1000, 30.0, "8 h 20 min")],
)
def test_long_times_are_told_roughly(frames, pace_s, expected):
    clock = Clock()
    tally = Tally(frames, clock)
    clock.now_s = pace_s
    tally.add(done(1))
    assert progress_text(tally).endswith(f"{expected} left")


@pytest.mark.parametrize("kind", ["terminal", "json", "openjd"])
def test_lost_surfaces_are_told_once(capsys, kind):
    """Of the first frame that has some, at the end, where nothing writes over it."""
    output = SimpleNamespace(pattern="out.####.exr")
    frames = [SimpleNamespace(frame=frame) for frame in (1, 2, 3)]
    plan = SimpleNamespace(frames=frames, job=SimpleNamespace(output=output))
    with progress_of(kind, plan) as tell:
        for frame, lost in ((1, ""), (2, "Some were merged."), (3, "Others were merged.")):
            tell(FrameDone(frame, None, False, lost))
    told = capsys.readouterr()
    sentence = "Frame 2: Some were merged."
    assert (told.out + told.err).count("merged") == 1 and sentence in told.out + told.err
    if kind == "json":
        assert json.loads(told.out.splitlines()[-1])["told"] == sentence


def test_a_terminal_is_told_and_left_clean(tmp_path):
    """Whatever the threads that read and write do to stderr meanwhile."""
    shot_file = write_shot_file(tmp_path)
    ours, theirs = pty.openpty()
    out = tmp_path / "out" / "n.####.exr"
    process = started("export", shot_file, "-o", out, stderr=theirs)
    os.close(theirs)
    shown = read_all(ours)
    assert process.communicate(timeout=60)[0] == f"{out}\n" and process.returncode == 0
    steps = re.findall(r"\r\x1b\[Kheatlens: frame (\d+), (\d) of 6 done(?:, \d+ s left)?", shown)
    assert steps[0] == ("1001", "0")  # at once: the first frame may take long
    assert steps[1:] == [(str(1000 + n), str(n)) for n in range(1, 7)]
    assert shown.endswith("\r\x1b[Kheatlens: 6 frames written.\r\n")


def test_a_log_file_gets_the_end_alone(tmp_path):
    shot_file = write_shot_file(tmp_path)
    out = tmp_path / "n.####.exr"
    process = started("export", shot_file, "-o", out, stderr=subprocess.PIPE)
    said = process.communicate(timeout=60)
    assert said == (f"{out}\n", "heatlens: 6 frames written.\n")


def read_all(descriptor: int) -> str:
    """Return all that is written to a terminal until its other end is closed."""
    data = b""
    while select.select([descriptor], [], [], 60)[0]:
        try:
            chunk = os.read(descriptor, 4096)
        except OSError:  # Linux's way of saying that nobody has it open any more
            chunk = b""
        if not chunk:
            break
        data += chunk
    os.close(descriptor)
    return data.decode()
