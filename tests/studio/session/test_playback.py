"""Which frame is due, by a clock that the test moves."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.curves.frames import Ending, FrameRange
from heatlens.studio.session.time.playback import CutTimes, Playback

FRAMES = FrameRange(1001, 1005)
RATE = 24.0


class Clock:
    """A clock that stands still until the test sets `now_s`."""

    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


def start_playback(ending: Ending, direction: int = 1, frame: int = 1001, every: bool = True):
    clock = Clock()
    playback = Playback(clock)
    playback.ending, playback.is_every_frame = ending, every
    return clock, playback, playback.play(direction, frame, FRAMES)


def collect_played_frames(ending: Ending, direction: int, frame: int, count: int) -> list[int]:
    """Play `count` frames at the exact rate; return the first frame and each later one."""
    clock, playback, frame = start_playback(ending, direction, frame)
    frames = [frame]
    for _ in range(count):
        clock.now_s += 1 / RATE
        frames.append(playback.next_frame(frames[-1], FRAMES, RATE, is_ready=True))
    return frames


@pytest.mark.parametrize(
    ("ending", "direction", "start", "last_digits"),
    [
        (Ending.LOOP, 1, 1003, [3, 4, 5, 1, 2, 3]),
        (Ending.LOOP, -1, 1002, [2, 1, 5, 4, 3]),
        (Ending.BOUNCE, 1, 1003, [3, 4, 5, 4, 3, 2, 1, 2, 3]),
        (Ending.BOUNCE, -1, 1002, [2, 1, 2, 3]),
        (Ending.ONCE, 1, 1004, [4, 5, 5, 5]),
        (Ending.ONCE, -1, 1002, [2, 1, 1]),
        (Ending.ONCE, 1, 1005, [1, 2, 3]),
        (Ending.LOOP, 1, 990, [1, 2, 3]),
        (Ending.LOOP, -1, 1009, [5, 4]),
    ],
)
def test_playback_follows_its_ending_and_begins_within_the_range(
    ending, direction, start, last_digits
):
    assert collect_played_frames(ending, direction, start, len(last_digits) - 1) == [
        1000 + d for d in last_digits
    ]


def test_playback_once_stops_at_the_last_frame():
    clock, playback, frame = start_playback(Ending.ONCE, 1, 1004)
    clock.now_s += 1 / RATE
    assert playback.next_frame(frame, FRAMES, RATE, is_ready=True) == 1005
    assert playback.direction == 0 and playback.seconds_until_due(RATE) is None


def test_every_frame_playback_waits_and_does_not_catch_up():
    clock, playback, frame = start_playback(Ending.LOOP)
    clock.now_s += 2.0
    assert playback.next_frame(frame, FRAMES, RATE, is_ready=False) == 1001
    assert playback.next_frame(frame, FRAMES, RATE, is_ready=True) == 1002
    clock.now_s += 0.5 / RATE
    late = playback.next_frame(1002, FRAMES, RATE, is_ready=True)
    assert (late, playback.next_frame(late, FRAMES, RATE, is_ready=True)) == (1003, 1003)


@given(seconds=st.floats(0.0, 10.0), rate=st.sampled_from([12.0, 24000 / 1001, 60.0]))
def test_real_time_playback_shows_the_frame_of_the_clock(seconds, rate):
    clock, playback, frame = start_playback(Ending.LOOP, every=False)
    for fraction in (0.3, 0.31, 0.9, 1.0):
        clock.now_s = 100.0 + fraction * seconds
        frame = playback.next_frame(frame, FRAMES, rate, is_ready=False)
    frames_passed = seconds * rate
    expected = {1001 + int(frames_passed + rounding) % 5 for rounding in (-1e-4, 0.0, 1e-4)}
    assert frame in expected


@given(
    ending=st.sampled_from(list(Ending)),
    direction=st.sampled_from([-1, 1]),
    start=st.integers(995, 1010),
    steps=st.lists(st.floats(0.0, 3.0), max_size=20),
    every=st.booleans(),
    count=st.integers(1, 6),
)
def test_playback_never_leaves_its_frame_range(ending, direction, start, steps, every, count):
    clock, frames = Clock(), FrameRange(1001, 1000 + count)
    playback = Playback(clock)
    playback.ending, playback.is_every_frame = ending, every
    frame = playback.play(direction, start, frames)
    for step in steps:
        clock.now_s += step
        assert frame in frames
        frame = playback.next_frame(frame, frames, RATE, is_ready=True)


def test_seconds_until_due_counts_down_to_the_next_frame():
    clock, playback, _ = start_playback(Ending.LOOP)
    assert playback.seconds_until_due(RATE) == pytest.approx(1 / RATE)
    assert not playback.is_due(RATE)
    clock.now_s += 1 / RATE
    assert playback.is_due(RATE) and 0 < playback.seconds_until_due(RATE) < 0.01


@pytest.mark.parametrize("every", [True, False])
def test_late_every_frame_playback_drops_no_frame_before_a_cut(every):
    """At 1004 and 0.2 s late: every frame shows 1005 before the next shot, real time does not."""
    clock, playback, frame = start_playback(Ending.REEL, 1, 1004, every)
    cuts = []
    playback.next_shot = lambda: not cuts.append(clock.now_s)
    clock.now_s += 0.2
    frame = playback.next_frame(frame, FRAMES, RATE, is_ready=True)
    assert (frame, len(cuts)) == ((1005, 0) if every else (1004, 1))


def test_waiting_for_the_next_shot_drops_none_of_its_frames():
    clock, playback, frame = start_playback(Ending.REEL, 1, 1005, every=False)
    playback.next_shot = lambda: True
    clock.now_s += 5.0
    assert playback.next_frame(frame, FRAMES, RATE, is_ready=True) == 1005
    clock.now_s += 5.0  # until it has arrived
    assert playback.next_frame(1001, FRAMES, RATE, is_ready=True) == 1001
    clock.now_s += 1 / RATE
    assert playback.next_frame(1001, FRAMES, RATE, is_ready=True) == 1002


@pytest.mark.parametrize(
    "cut_frames",
    [(1001, 1001, 1002, 1002, 1003), (1001, 1003, 1005), (1005, 1004, 1003), (1002,) * 4],
    ids=["half speed", "double speed", "backwards", "freeze"],
)
def test_retimed_cut_plays_the_frames_that_the_reel_shows_at_its_rate(cut_frames):
    clock, playback, _ = start_playback(Ending.REEL, 1, 1001)
    playback.cut, cuts, rate = CutTimes(cut_frames, 30.0), [], 30.0
    playback.next_shot = lambda: not cuts.append(clock.now_s)
    frames = [cut_frames[0]]
    while not cuts:
        clock.now_s += 1 / rate
        assert playback.is_due(RATE)
        frames.append(playback.next_frame(frames[-1], FRAMES, RATE, is_ready=True))
    assert tuple(frames[:-1]) == cut_frames
    playback.ending = Ending.LOOP  # within the shot, each frame plays once
    assert playback.seconds_until_due(RATE) == pytest.approx(1 / RATE, abs=0.05)


@pytest.mark.parametrize("direction", [1, -1])
def test_reel_playback_without_a_next_shot_starts_over(direction):
    start = 1004 if direction > 0 else 1002
    assert collect_played_frames(Ending.REEL, direction, start, 2)[-1] == (
        1001 if direction > 0 else 1005
    )
