"""The playhead and the frames of the open source: moved, played, cut to in and out, written."""

import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.studio.session.time.timeline import FrameStates, Run, Timeline, _range, runs_of
from support.evening import FIRST, LAST, begun, settled, until
from support.session_files import room_file

FOCUS = LensParameter.FOCUS_DISTANCE


@pytest.fixture
def time(walls) -> Timeline:
    return walls.time.timeline


def frame(walls):
    return walls.editing.frame


def test_it_stays_within_the_frames_and_tells_its_direction(walls, time):
    assert time.frames == FrameRange(FIRST, LAST) == time.played == time.reach
    assert time.is_sequence and time.has_time and time.is_shown and time.cache is not None
    time.go(FIRST + 5)
    assert frame(walls) == FIRST + 5 and time.direction == 1
    time.step(-2)
    assert frame(walls) == FIRST + 3 and time.direction == -1
    time.go(FIRST + 3)
    assert time.direction == -1
    time.go(LAST + 99)
    assert frame(walls) == LAST
    time.go(0)
    assert frame(walls) == FIRST
    time.put(LAST + 7)  # as playback does, which knows where it goes
    assert frame(walls) == LAST + 7


def test_keys_are_stops_on_the_way(walls, time):
    for at in (FIRST + 4, FIRST + 10):
        time.go(at)
        walls.time.keys.set_here()
    time.go(FIRST + 7)
    time.go_to_key(1)
    assert frame(walls) == FIRST + 10
    time.go_to_key(1)
    assert frame(walls) == FIRST + 10  # there is none beyond
    time.go_to_key(-1)
    assert frame(walls) == FIRST + 4
    time.go_to_key(-1)
    assert frame(walls) == FIRST + 4
    walls.time.keys.choose_all()
    walls.time.keys.move(0.5)
    time.go(FIRST)
    time.go_to_key(1)
    assert frame(walls) == FIRST + 5  # the next whole frame
    time.go(FIRST + 8)
    time.go_to_key(-1)
    assert frame(walls) == FIRST + 4


def test_keys_beyond_the_frames_are_within_reach(walls, time):
    shot = walls.editing.shot
    walls.editing.do(shot.with_key(FIRST - 3.5, FOCUS, 3.0).with_key(LAST + 5.5, FOCUS, 3.0))
    assert time.reach == FrameRange(FIRST - 4, LAST + 6)
    assert time.frames == FrameRange(FIRST, LAST)
    time.go(LAST + 99)
    assert frame(walls) == LAST + 6


def test_in_and_out_are_set_at_the_playhead(walls, time):
    time.go(FIRST + 4)
    time.set_in()
    assert walls.editing.shot.in_out == FrameRange(FIRST + 4, LAST) == time.played
    time.go(FIRST + 9)
    time.set_out()
    assert time.played == FrameRange(FIRST + 4, FIRST + 9)
    for direction, end in ((1, FIRST + 9), (-1, FIRST + 4)):
        time.go_to_end(direction)
        assert frame(walls) == end
    time.go(FIRST + 2)
    time.set_out()  # before the in point, which comes along
    assert time.played == FrameRange(FIRST + 2, FIRST + 2)
    time.go(FIRST + 6)
    time.set_in()
    assert time.played == FrameRange(FIRST + 6, FIRST + 6)
    time.clear_in_out()
    assert walls.editing.shot.in_out is None and time.played == FrameRange(FIRST, LAST)
    time.go(FIRST)
    time.set_in()
    assert walls.editing.shot.in_out is None  # all frames are no choice


def test_it_plays_and_stops_at_a_second_press(walls, time):
    time.play(1)
    assert time.playback.direction == 1
    time.play(-1)
    assert time.playback.direction == -1
    time.play(-1)
    assert time.playback.direction == 0
    time.play(1)
    time.go(FIRST + 3)
    assert time.playback.direction == 0
    time.set_in()
    time.set_out()
    time.play(1)  # one frame alone
    assert time.playback.direction == 0


def test_a_gap_ends_playback_where_missing_frames_do(walls, time, tmp_path):
    (tmp_path / f"walls.{FIRST + 2}.exr").unlink()
    walls.files.commands.open(str(tmp_path / "walls.####.exr"))
    until(walls, lambda: time.cache is not None and not time.cache.sequence.has(FIRST + 2), "gap")
    time.play(1)
    assert time.may_play(FIRST + 2) and time.missing == "hold"
    time.missing = "stop"
    assert time.may_play(FIRST + 3)
    assert not time.may_play(FIRST + 2) and time.playback.direction == 0
    assert "is missing" in walls.messages.text


def test_the_states_of_frames_come_as_runs(walls, time):
    until(walls, lambda: time.cache.get(FIRST + 7) is not None, "eight frames")
    (run,) = time.runs()
    assert (run.first, run.state) == (FIRST, "ready") and run.last >= FIRST + 7
    assert not time.is_behind


def test_a_still_reaches_far_and_has_the_range_of_its_keys(tmp_path):
    session = begun(tmp_path / "preferences", str(room_file(tmp_path / "still.exr", 8, 6)))
    settled(session)
    try:
        time = session.time.timeline
        start = session.editing.frame
        assert not (time.is_sequence or time.has_time or time.is_shown) and time.frames is None
        assert time.played == FrameRange(start, start) == time.reach
        time.go(200_000)
        assert session.editing.frame == 100_000
        time.go(-200_000)
        assert session.editing.frame == -100_000
        time.go(5)
        session.time.keys.set_here()
        time.go(9)
        session.time.keys.set_here()
        assert time.frames == FrameRange(5, 9) and time.has_time and time.is_shown
        time.go(20)
        assert time.reach == FrameRange(5, 20) and time.runs() == (Run(1, 1, "ready"),)
        time.play(1)
        assert session.editing.frame == 5  # it begins anew
        time.set_in()
        assert session.editing.shot.in_out is None  # which is the first of all frames
    finally:
        session.close()


def test_a_shot_has_at_most_a_million_frames():
    assert _range(3.5, 9.2) == FrameRange(3, 10)
    assert _range(0, 5_000_000) == FrameRange(0, 999_999)


def test_the_timecode_counts_from_the_first_frame(walls, time):
    assert time.timecode == ""
    time.go(FIRST + 24)
    time.go(FIRST + 5)
    assert time.start_timecode("  ") == ""
    assert time.start_timecode("01:00:00:05") == "01:00:00:00"
    for wrong in ("01:00:00:24", "soon"):
        with pytest.raises(InputError):
            time.start_timecode(wrong)
    walls.editing.do(walls.editing.shot.started_at("01:00:00:00"))
    assert time.timecode == "01:00:00:05"


def test_runs_join_neighbours_in_one_state_and_leave_out_what_is_on_disk_alone():
    states = {1: "ready", 2: "ready", 3: "absent", 4: "waiting", 5: "damaged", 6: "damaged"}
    assert runs_of(states) == (Run(1, 2, "ready"), Run(4, 4, "waiting"), Run(5, 6, "damaged"))
    assert runs_of({}) == ()


def test_states_of_a_long_film_are_read_in_a_twentieth_of_the_time():
    now = [100.0]

    class Cache:
        def states(self):
            now[0] += 0.2  # a long film
            return {1: "ready"}

    cache, states = Cache(), FrameStates(lambda: now[0])
    assert states.is_behind(cache, 1)
    assert states.runs(cache, 1) == (Run(1, 1, "ready"),) and not states.is_behind(cache, 1)
    read_at = now[0]
    states.runs(cache, 1)
    assert now[0] == read_at  # nothing is new
    now[0] = read_at - 0.2 + 4.1
    states.runs(cache, 2)
    assert now[0] == read_at - 0.2 + 4.3 and not states.is_behind(cache, 2)
    states.runs(cache, 3)
    assert states.is_behind(cache, 3)  # it was read just now
