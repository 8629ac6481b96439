"""Marks on plates: set, named, focused on, pulled to and followed, one step of undo each."""

from dataclasses import replace

import pytest

from heatlens.core.base.errors import HeatlensError
from heatlens.core.model.curves.interpolation import Interpolation
from heatlens.core.model.marks.marks import DistanceMark, PointMark
from heatlens.core.model.shot.pull import EASE_PERCENT, PullShape
from heatlens.media.plate.coc_line import focused_at_pixel
from heatlens.studio.session.marks.focus_pulls import PULL_FRAMES
from support.evening import FIRST, LAST, LEFT, RIGHT, begun, settled, until, write_plates
from support.session_files import room_file


@pytest.fixture
def marks(walls):
    return walls.time.marks


def focus(walls, frame=None):
    at = walls.editing.frame if frame is None else frame
    return walls.editing.shot.lens_at(at).focus_distance_m


def named(walls):
    return [mark.name for mark in walls.editing.shot.marks]


def pulled(walls):
    """Make the pull, and wait for the frame of its arrival."""
    marks = walls.time.marks
    marks.pulls.make()
    until(walls, lambda: not marks.distances.is_waited_for, "the pull")


def test_marks_are_set_on_what_is_seen_and_on_the_focus(walls, marks):
    marks.set_point(LEFT)
    marks.set_here()
    a, b = walls.editing.shot.marks
    assert a == PointMark("A", *map(float, LEFT)) and b == DistanceMark("B", 4.0)
    assert marks.pulls.target == "B" and "B" in walls.messages.text
    assert marks.distances.of_m(a) == 2.0 and marks.distances.of_m(b) == 4.0
    walls.editing.undo()
    assert (
        named(walls) == ["A"]
        and walls.editing.shot.mark_named("A") == a
        and walls.editing.shot.mark_named("B") is None
    )
    marks.set_point((4000, 4000))
    assert named(walls) == ["A"] and "Mark" not in walls.messages.text


def test_a_mark_without_an_open_picture_is_none(tmp_path):
    session = begun(tmp_path / "preferences")
    try:
        session.time.marks.set_point(LEFT)
        assert session.editing.shot.marks == ()
    finally:
        session.close()


def test_a_renamed_mark_is_still_the_one_to_pull_to(walls, marks):
    marks.set_point(LEFT)
    marks.set_point(RIGHT)
    a, b = walls.editing.shot.marks
    marks.pulls.origin = "A"
    marks.change(b, DistanceMark("actor", 5.0))
    assert named(walls) == ["A", "actor"] and (marks.pulls.origin, marks.pulls.target) == (
        "A",
        "actor",
    )
    marks.change(a, PointMark("door", a.x_px, a.y_px))
    assert (marks.pulls.origin, marks.pulls.target) == ("door", "actor")
    with pytest.raises(HeatlensError):
        marks.change(walls.editing.shot.mark_named("door"), DistanceMark("actor", 1.0))
    marks.delete(walls.editing.shot.mark_named("door"))
    assert named(walls) == ["actor"]


def test_the_focus_goes_to_a_mark_as_one_step(walls, marks):
    marks.set_point(RIGHT)
    (mark,) = walls.editing.shot.marks
    marks.go(mark)
    assert focus(walls) == 8.0 and not walls.editing.is_unsettled
    walls.editing.undo()
    assert focus(walls) == 4.0 and named(walls) == ["A"]
    marks.go(PointMark("Z", 4000.0, 4000.0))
    assert focus(walls) == 4.0 and " Z " in walls.messages.text


def test_a_pull_goes_from_here_or_from_a_mark(walls, marks):
    pulled(walls)
    assert walls.messages.text and marks.pulls.made == 0
    marks.set_point(LEFT)
    marks.set_point(RIGHT)
    marks.pulls.origin, marks.pulls.target = None, "B"
    marks.pulls.lengthen(6)
    assert marks.pulls.frames == 6
    walls.time.timeline.go(FIRST + 2)
    pulled(walls)
    assert [focus(walls, FIRST + at) for at in (0, 2, 8, 20)] == pytest.approx([4, 4, 8, 8])
    assert marks.pulls.made == 1
    walls.editing.undo()
    marks.pulls.origin, marks.pulls.shape = "A", PullShape.LINEAR
    pulled(walls)
    assert [focus(walls, FIRST + at) for at in (2, 5, 8)] == pytest.approx([2.0, 3.2, 8.0])
    marks.pulls.target, marks.pulls.frames = "A", 0
    before = walls.editing.shot
    pulled(walls)
    assert walls.editing.shot == before and "0 frames" in walls.messages.text


def test_a_pull_is_suggested_as_long_as_the_last_where_it_fits(walls, marks):
    assert marks.pulls.frames == PULL_FRAMES == 18 and marks.pulls.ease_percent == EASE_PERCENT
    assert marks.pulls.shape is PullShape.EASE
    marks.set_point(LEFT)
    marks.pulls.begin()
    assert marks.pulls.frames == 18 and marks.pulls.target == "A"
    walls.time.timeline.go(LAST - 5)
    marks.pulls.begin()
    assert marks.pulls.frames == 5 and marks.pulls.past_end == ""
    marks.pulls.target = "gone"
    walls.time.timeline.go(LAST)
    marks.pulls.begin()
    assert marks.pulls.frames == 18 and marks.pulls.target == "A"
    assert f"frame {LAST + 18}" in marks.pulls.past_end and f"{LAST} is the last" in (
        marks.pulls.past_end
    )
    pulled(walls)
    assert walls.messages.text == marks.pulls.past_end
    walls.time.timeline.go(LAST - 18)
    assert marks.pulls.past_end == ""


def test_a_pull_is_offered_to_the_next_mark(walls, marks):
    """In their order, whichever was set last: A to B to C takes no choice on the way."""
    marks.set_point(LEFT)
    marks.set_point(RIGHT)
    walls.lens.commands.focus(5.0)
    marks.set_here()
    offered = []
    marks.go(walls.editing.shot.mark_named("A"))
    marks.pulls.lengthen(6)
    for _ in range(3):
        marks.pulls.begin()
        offered.append(marks.pulls.target)
        pulled(walls)
        walls.time.timeline.go(walls.editing.frame + 6)
    assert offered == ["B", "C", "A"]
    assert [focus(walls, FIRST + at) for at in (0, 6, 12, 18)] == pytest.approx([2, 8, 5, 2])


def test_off_all_marks_a_pull_is_offered_to_the_one_after_the_last_pull(walls, marks):
    marks.set_point(LEFT)
    marks.set_point(RIGHT)
    walls.lens.commands.focus(0.3)
    marks.pulls.begin()
    assert marks.pulls.target == "A"
    pulled(walls)
    walls.time.timeline.go(FIRST)
    marks.pulls.begin()
    assert marks.pulls.target == "B"


@pytest.mark.parametrize(
    "lean",
    [
        {"tilt_deg": 2.0, "tilt_direction_deg": 90.0},
        {"split_dioptres": 0.2, "split_direction_deg": 180.0},  # over the left half alone
    ],
)
def test_a_leaning_focus_is_set_so_that_the_mark_is_sharp(walls, marks, lean):
    """At its own point: pulls, flags on the bar and following go there."""
    marks.set_point(LEFT)
    marks.set_here()
    leaning = replace(walls.editing.lens, **lean)
    walls.editing.edit_lens(leaning)
    a = walls.editing.shot.mark_named("A")
    wanted_m = focused_at_pixel(walls.source.plate, leaning, *LEFT).focus_distance_m
    assert abs(wanted_m - 2.0) > 0.1
    marks.go(a)
    assert focus(walls) == pytest.approx(wanted_m)
    assert dict(walls.facts.marks_m) == pytest.approx({"A": wanted_m, "B": 4.0})
    assert marks.distances.of_m(a) == 2.0  # as a tape measures it
    marks.follow(a)
    until(walls, lambda: walls.editing.shot.key_frames, "the keys")
    assert [focus(walls, at) for at in (FIRST, LAST)] == pytest.approx([wanted_m] * 2)


def test_a_still_has_no_last_frame(tmp_path):
    session = begun(tmp_path / "preferences", str(room_file(tmp_path / "still.exr")))
    settled(session)
    try:
        marks = session.time.marks
        marks.set_here()
        marks.pulls.begin()
        assert marks.pulls.past_end == "" and marks.pulls.frames == 18
        marks.follow(PointMark("A", 3.0, 3.0))
        until(session, lambda: not marks.is_reading, "the still")
    finally:
        session.close()


def test_a_pull_between_in_and_out_is_reversed_and_a_focus_held(walls, marks):
    marks.pulls.reverse()
    assert "two keys" in walls.messages.text
    marks.set_point(LEFT)
    marks.pulls.lengthen(8)
    pulled(walls)
    ends = focus(walls, FIRST), focus(walls, FIRST + 8)
    marks.pulls.reverse()
    assert (focus(walls, FIRST + 8), focus(walls, FIRST)) == ends
    marks.pulls.hold()
    keys = walls.editing.shot.curves.focus_distance_m.keys
    assert keys[0].interpolation is Interpolation.HOLD
    assert focus(walls, FIRST + 7) == focus(walls, FIRST)


def test_the_focus_follows_a_point_through_the_played_frames(walls, marks):
    walls.time.timeline.go(FIRST + 2)
    walls.time.timeline.set_in()
    walls.time.timeline.go(FIRST + 14)
    walls.time.timeline.set_out()
    mark = PointMark("A", *map(float, RIGHT))
    marks.follow(mark)
    assert marks.is_reading
    until(walls, lambda: not marks.is_reading, "all frames")
    frames = [key.frame for key in walls.editing.shot.curves.focus_distance_m.keys]
    assert frames == [FIRST + 2, FIRST + 14]  # the wall stands still
    assert focus(walls, FIRST + 14) == 8.0 and f"from {FIRST + 2} on" in walls.messages.text
    walls.editing.undo()
    assert not walls.editing.shot.key_frames


def test_a_damaged_frame_ends_following_with_its_name(tmp_path):
    pattern = write_plates(tmp_path)
    (tmp_path / f"walls.{FIRST + 20}.exr").write_bytes(b"damaged")
    session = begun(tmp_path / "preferences", pattern)
    settled(session)
    try:
        marks = session.time.marks
        marks.follow(PointMark("A", *map(float, RIGHT)))
        assert "to follow A" in session.messages.text
        until(session, lambda: not marks.is_reading, "the end")
        assert f"walls.{FIRST + 20}.exr" in session.messages.text
        assert not session.editing.shot.key_frames
    finally:
        session.close()


def test_a_missing_frame_is_followed_on_the_one_before(tmp_path):
    pattern = write_plates(tmp_path)
    (tmp_path / f"walls.{FIRST + 3}.exr").unlink()
    session = begun(tmp_path / "preferences", pattern)
    settled(session)
    try:
        session.time.marks.follow(PointMark("A", *map(float, LEFT)))
        until(session, lambda: not session.time.marks.is_reading, "the end")
        assert focus(session, FIRST + 3) == 2.0
        assert session.editing.shot.key_frames == (FIRST, LAST)
    finally:
        session.close()


def test_nothing_open_is_followed_nowhere(tmp_path):
    session = begun(tmp_path / "preferences")
    try:
        session.time.marks.follow(PointMark("A", 1.0, 1.0))
        assert "scene" in session.messages.text
    finally:
        session.close()
