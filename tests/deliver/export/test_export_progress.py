"""Test the progress of an export: a line on a terminal, only the end in a log file."""

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
from support.command_line import start_heatlens
from support.exports import write_shot_file
from support.patience import PATIENCE_S


def frame_done(frame: int, was_there: bool = False) -> FrameDone:
    return FrameDone(frame, None, was_there)


class Clock:
    """A clock whose time `now_s` a test sets."""

    now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


def test_tally_estimates_time_left_from_finished_frames():
    clock = Clock()
    tally = Tally(10, clock)
    assert tally.left_s is None and progress_text(tally) == "0 of 10 done"
    for frame, now_s in ((1, 2.0), (2, 4.0), (3, 6.0)):
        clock.now_s = now_s
        tally.add(frame_done(frame))
    assert tally.left_s == pytest.approx(7 * 2.0)
    assert progress_text(tally) == "3 of 10 done, 14 s left"


def test_tally_counts_existing_frames_but_not_their_time():
    clock = Clock()
    tally = Tally(10, clock)
    for frame in range(6):
        clock.now_s += 0.1
        tally.add(frame_done(frame, was_there=True))
    clock.now_s += 3.0
    tally.add(frame_done(7))
    assert (tally.done_count, tally.finished_before, tally.written) == (7, 6, [7])
    assert tally.left_s == pytest.approx(3 * 3.0)


@pytest.mark.parametrize(
    ("frames", "pace_s", "expected"),
    [(10, 1.0, "9 s"), (100, 1.0, "99 s"), (100, 2.0, "3 min"), (1000, 30.0, "8 h 20 min")],
)
def test_progress_text_rounds_long_times(frames, pace_s, expected):
    clock = Clock()
    tally = Tally(frames, clock)
    clock.now_s = pace_s
    tally.add(frame_done(1))
    assert progress_text(tally).endswith(f"{expected} left")


@pytest.mark.parametrize("kind", ["terminal", "json", "openjd"])
def test_progress_reports_merged_surfaces_once_at_end(capsys, kind):
    """The message of the first such frame comes at the end, where no progress overwrites it."""
    output = SimpleNamespace(pattern="out.####.exr")
    frames = [SimpleNamespace(frame=frame) for frame in (1, 2, 3)]
    plan = SimpleNamespace(frames=frames, job=SimpleNamespace(output=output))
    with progress_of(kind, plan) as report:
        for frame, lost in ((1, ""), (2, "Some were merged."), (3, "Others were merged.")):
            report(FrameDone(frame, None, was_there=False, surfaces_lost=lost))
    captured = capsys.readouterr()
    sentence = "Frame 2: Some were merged."
    assert (captured.out + captured.err).count(
        "merged"
    ) == 1 and sentence in captured.out + captured.err
    if kind == "json":
        assert json.loads(captured.out.splitlines()[-1])["told"] == sentence


def test_progress_line_on_terminal_is_updated_and_cleared(tmp_path):
    """The reading and writing threads must not disturb the line on stderr."""
    shot_file = write_shot_file(tmp_path)
    own_end, process_end = pty.openpty()
    out = tmp_path / "out" / "n.####.exr"
    process = start_heatlens("export", shot_file, "-o", out, stderr=process_end)
    os.close(process_end)
    terminal_text = read_terminal(own_end)
    assert process.communicate(timeout=PATIENCE_S)[0] == f"{out}\n" and process.returncode == 0
    steps = re.findall(
        r"\r\x1b\[Kheatlens: frame (\d+), (\d) of 6 done(?:, \d+ s left)?", terminal_text
    )
    assert steps[0] == ("1001", "0")  # at once: the first frame may take long
    assert steps[1:] == [(str(1000 + n), str(n)) for n in range(1, 7)]
    assert terminal_text.endswith("\r\x1b[Kheatlens: 6 frames written.\r\n")


def test_progress_in_log_file_is_the_final_line_only(tmp_path):
    shot_file = write_shot_file(tmp_path)
    out = tmp_path / "n.####.exr"
    process = start_heatlens("export", shot_file, "-o", out, stderr=subprocess.PIPE)
    outputs = process.communicate(timeout=PATIENCE_S)
    assert outputs == (f"{out}\n", "heatlens: 6 frames written.\n")


def read_terminal(descriptor: int) -> str:
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
