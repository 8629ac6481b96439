"""The playhead and the frames of the open source: moved, played, cut to in and out, written."""

import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.media.frame_cache.frame_states import FrameStates, Run, runs_of
from heatlens.studio.session.time.timeline import Timeline, _range
from support.evening import FIRST, LAST, begin_session, run_until, run_until_settled
from support.session_files import room_file

FOCUS = LensParameter.FOCUS_DISTANCE


@pytest.fixture
def time(session) -> Timeline:
    return session.time.timeline


def frame(session):
    return session.editing.frame


def test_playhead_stays_within_frames_and_keeps_its_direction(session, time):
    assert time.frames == FrameRange(FIRST, LAST) == time.played == time.visible_range
    assert time.is_sequence and time.has_time and time.is_shown and time.cache is not None
    time.go_to(FIRST + 5)
    assert frame(session) == FIRST + 5 and time.direction == 1
    time.step(-2)
    assert frame(session) == FIRST + 3 and time.direction == -1
    time.go_to(FIRST + 3)
    assert time.direction == -1
    time.go_to(LAST + 99)
    assert frame(session) == LAST
    time.go_to(0)
    assert frame(session) == FIRST
    time.move_playhead(LAST + 7)  # as playback does, which knows where it goes
    assert frame(session) == LAST + 7


def test_go_to_key_moves_to_the_next_whole_frame_with_a_key(session, time):
    for at in (FIRST + 4, FIRST + 10):
        time.go_to(at)
        session.time.keys.set_here()
    time.go_to(FIRST + 7)
    time.go_to_key(1)
    assert frame(session) == FIRST + 10
    time.go_to_key(1)
    assert frame(session) == FIRST + 10  # there is none beyond
    time.go_to_key(-1)
    assert frame(session) == FIRST + 4
    time.go_to_key(-1)
    assert frame(session) == FIRST + 4
    session.time.keys.select_all()
    session.time.keys.move(0.5)
    time.go_to(FIRST)
    time.go_to_key(1)
    assert frame(session) == FIRST + 5  # the next whole frame
    time.go_to(FIRST + 8)
    time.go_to_key(-1)
    assert frame(session) == FIRST + 4


def test_reach_includes_keys_outside_the_frames(session, time):
    shot = session.editing.shot
    session.editing.do(shot.with_key(FIRST - 3.5, FOCUS, 3.0).with_key(LAST + 5.5, FOCUS, 3.0))
    assert time.visible_range == FrameRange(FIRST - 4, LAST + 6)
    assert time.frames == FrameRange(FIRST, LAST)
    time.go_to(LAST + 99)
    assert frame(session) == LAST + 6


def test_set_in_and_set_out_use_the_playhead(session, time):
    time.go_to(FIRST + 4)
    time.set_in()
    assert session.editing.shot.in_out == FrameRange(FIRST + 4, LAST) == time.played
    time.go_to(FIRST + 9)
    time.set_out()
    assert time.played == FrameRange(FIRST + 4, FIRST + 9)
    for direction, end in ((1, FIRST + 9), (-1, FIRST + 4)):
        time.go_to_end(direction)
        assert frame(session) == end
    time.go_to(FIRST + 2)
    time.set_out()  # before the in point, which comes along
    assert time.played == FrameRange(FIRST + 2, FIRST + 2)
    time.go_to(FIRST + 6)
    time.set_in()
    assert time.played == FrameRange(FIRST + 6, FIRST + 6)
    time.clear_in_out()
    assert session.editing.shot.in_out is None and time.played == FrameRange(FIRST, LAST)
    time.go_to(FIRST)
    time.set_in()
    assert session.editing.shot.in_out is None  # all frames are no choice


def test_play_stops_at_a_second_press(session, time):
    time.play(1)
    assert time.playback.direction == 1
    time.play(-1)
    assert time.playback.direction == -1
    time.play(-1)
    assert time.playback.direction == 0
    time.play(1)
    time.go_to(FIRST + 3)
    assert time.playback.direction == 0
    time.set_in()
    time.set_out()
    time.play(1)  # one frame alone
    assert time.playback.direction == 0


def test_missing_frame_stops_playback_only_with_missing_stop(session, time, tmp_path):
    (tmp_path / f"walls.{FIRST + 2}.exr").unlink()
    session.files.commands.open(str(tmp_path / "walls.####.exr"))
    run_until(
        session,
        lambda: time.cache is not None and not time.cache.sequence.has_file(FIRST + 2),
        "gap",
    )
    time.play(1)
    assert time.can_play(FIRST + 2) and time.missing == "hold"
    time.missing = "stop"
    assert time.can_play(FIRST + 3)
    assert not time.can_play(FIRST + 2) and time.playback.direction == 0
    assert "is missing" in session.messages.text


def test_timeline_runs_report_frames_in_memory(session, time):
    first_frames = range(FIRST, FIRST + 8)
    run_until(session, lambda: all(map(time.cache.get, first_frames)), "eight frames in a row")
    run = time.runs()[0]  # a later frame may arrive before the ninth
    assert (run.first, run.state) == (FIRST, "ready") and run.last >= FIRST + 7
    assert not time.is_outdated


def test_still_has_the_frame_range_of_its_keys(tmp_path):
    session = begin_session(tmp_path / "preferences", str(room_file(tmp_path / "still.exr", 8, 6)))
    run_until_settled(session)
    try:
        time = session.time.timeline
        start = session.editing.frame
        assert not (time.is_sequence or time.has_time or time.is_shown) and time.frames is None
        assert time.played == FrameRange(start, start) == time.visible_range
        time.go_to(200_000)
        assert session.editing.frame == 100_000
        time.go_to(-200_000)
        assert session.editing.frame == -100_000
        time.go_to(5)
        session.time.keys.set_here()
        time.go_to(9)
        session.time.keys.set_here()
        assert time.frames == FrameRange(5, 9) and time.has_time and time.is_shown
        time.go_to(20)
        assert time.visible_range == FrameRange(5, 20) and time.runs() == (Run(1, 1, "ready"),)
        time.play(1)
        assert session.editing.frame == 5  # it begins anew
        time.set_in()
        assert session.editing.shot.in_out is None  # which is the first of all frames
    finally:
        session.close()


def test_frame_range_is_limited_to_a_million_frames():
    assert _range(3.5, 9.2) == FrameRange(3, 10)
    assert _range(0, 5_000_000) == FrameRange(0, 999_999)


def test_timecode_counts_from_the_first_frame(session, time):
    assert time.timecode == ""
    time.go_to(FIRST + 24)
    time.go_to(FIRST + 5)
    assert time.start_timecode("  ") == ""
    assert time.start_timecode("01:00:00:05") == "01:00:00:00"
    for wrong in ("01:00:00:24", "soon"):
        with pytest.raises(InputError):
            time.start_timecode(wrong)
    session.editing.do(session.editing.shot.with_start_timecode("01:00:00:00"))
    assert time.timecode == "01:00:00:05"


def test_runs_of_joins_frames_of_one_state_and_omits_absent_frames():
    states = {1: "ready", 2: "ready", 3: "absent", 4: "waiting", 5: "damaged", 6: "damaged"}
    assert runs_of(states) == (Run(1, 2, "ready"), Run(4, 4, "waiting"), Run(5, 6, "damaged"))
    assert runs_of({}) == ()


def test_slow_frame_states_are_read_at_most_a_twentieth_of_the_time():
    clock_s = [100.0]

    class Cache:
        def states(self):
            clock_s[0] += 0.2  # a long film
            return {1: "ready"}

    cache, states = Cache(), FrameStates(lambda: clock_s[0])
    assert states.is_outdated(cache, 1)
    assert states.runs(cache, 1) == (Run(1, 1, "ready"),) and not states.is_outdated(cache, 1)
    read_at = clock_s[0]
    states.runs(cache, 1)
    assert clock_s[0] == read_at  # nothing is new
    clock_s[0] = read_at - 0.2 + 4.1
    states.runs(cache, 2)
    assert clock_s[0] == read_at - 0.2 + 4.3 and not states.is_outdated(cache, 2)
    states.runs(cache, 3)
    assert states.is_outdated(cache, 3)  # it was read just now
