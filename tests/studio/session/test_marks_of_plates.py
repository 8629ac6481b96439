"""Marks on plates: set, named, focused on, pulled to and followed, one step of undo each."""

from dataclasses import replace

import pytest

from heatlens.core.base.errors import HeatlensError
from heatlens.core.model.curves.interpolation import Interpolation
from heatlens.core.model.focus.focus_offset import focus_offset_of
from heatlens.core.model.marks.marks import DistanceMark, PointMark
from heatlens.core.model.shot.pull import EASE_PERCENT, PullShape
from heatlens.media.plate.coc_line import focused_at_pixel
from heatlens.studio.session.marks.focus_pulls import PULL_FRAMES
from support.evening import (
    FIRST,
    HEIGHT,
    LAST,
    LEFT,
    RIGHT,
    WIDTH,
    begin_session,
    run_until,
    run_until_settled,
    write_plates,
)
from support.session_files import room_file


@pytest.fixture
def marks(session):
    return session.time.marks


def focus_m(session, frame=None):
    focus_frame = session.editing.frame if frame is None else frame
    return session.editing.shot.lens_at(focus_frame).focus_distance_m


def mark_names(session):
    return [mark.name for mark in session.editing.shot.marks]


def make_pull(session):
    """Make the pull, and wait for the frame of its arrival."""
    marks = session.time.marks
    marks.pulls.make()
    run_until(session, lambda: not marks.distances.has_request, "the pull")


def test_set_point_marks_a_surface_and_set_here_marks_the_focus(session, marks):
    marks.set_point(LEFT)
    marks.set_here()
    a, b = session.editing.shot.marks
    assert a == PointMark("A", *map(float, LEFT)) and b == DistanceMark("B", 4.0)
    assert marks.pulls.target == "B" and "B" in session.messages.text
    assert marks.distances.distance_m(a) == 2.0 and marks.distances.distance_m(b) == 4.0
    session.editing.undo()
    assert (
        mark_names(session) == ["A"]
        and session.editing.shot.mark_named("A") == a
        and session.editing.shot.mark_named("B") is None
    )
    marks.set_point((4000, 4000))
    assert mark_names(session) == ["A"] and "Mark" not in session.messages.text


def test_set_point_without_an_open_picture_sets_no_mark(tmp_path):
    session = begin_session(tmp_path / "preferences")
    try:
        session.time.marks.set_point(LEFT)
        assert session.editing.shot.marks == ()
    finally:
        session.close()


def test_renamed_marks_stay_origin_and_target_of_the_pull(session, marks):
    marks.set_point(LEFT)
    marks.set_point(RIGHT)
    a, b = session.editing.shot.marks
    marks.pulls.origin = "A"
    marks.change(b, DistanceMark("actor", 5.0))
    assert mark_names(session) == ["A", "actor"] and (marks.pulls.origin, marks.pulls.target) == (
        "A",
        "actor",
    )
    marks.change(a, PointMark("door", a.x_px, a.y_px))
    assert (marks.pulls.origin, marks.pulls.target) == ("door", "actor")
    with pytest.raises(HeatlensError):
        marks.change(session.editing.shot.mark_named("door"), DistanceMark("actor", 1.0))
    marks.delete(session.editing.shot.mark_named("door"))
    assert mark_names(session) == ["actor"]


def test_go_focuses_on_a_mark_in_one_undo_step(session, marks):
    marks.set_point(RIGHT)
    (mark,) = session.editing.shot.marks
    marks.focus_on(mark)
    assert focus_m(session) == 8.0 and not session.editing.is_unsettled
    session.editing.undo()
    assert focus_m(session) == 4.0 and mark_names(session) == ["A"]
    marks.focus_on(PointMark("Z", 4000.0, 4000.0))
    assert focus_m(session) == 4.0 and " Z " in session.messages.text


def test_pull_starts_at_the_playheads_focus_or_at_a_mark(session, marks):
    make_pull(session)
    assert session.messages.text and marks.pulls.pull_count == 0
    marks.set_point(LEFT)
    marks.set_point(RIGHT)
    marks.pulls.origin, marks.pulls.target = None, "B"
    marks.pulls.set_length(6)
    assert marks.pulls.frames == 6
    session.time.timeline.go_to(FIRST + 2)
    make_pull(session)
    assert [focus_m(session, FIRST + at) for at in (0, 2, 8, 20)] == pytest.approx([4, 4, 8, 8])
    assert marks.pulls.pull_count == 1
    session.editing.undo()
    marks.pulls.origin, marks.pulls.shape = "A", PullShape.LINEAR
    make_pull(session)
    assert [focus_m(session, FIRST + at) for at in (2, 5, 8)] == pytest.approx([2.0, 3.2, 8.0])
    marks.pulls.target, marks.pulls.frames = "A", 0
    before = session.editing.shot
    make_pull(session)
    assert session.editing.shot == before and "0 frames" in session.messages.text


def test_pull_suggests_the_only_mark_set_since_the_last_one(session, marks):
    marks.set_point(LEFT)
    marks.set_point(RIGHT)
    marks.focus_on(session.editing.shot.marks[0])
    marks.pulls.suggest()
    make_pull(session)
    session.editing.edit_lens(replace(session.editing.lens, focus_distance_m=4.0))
    marks.set_here()
    marks.focus_on(session.editing.shot.marks[0])
    marks.pulls.suggest()
    assert marks.pulls.target == "C"
    marks.focus_on(session.editing.shot.marks[2])
    marks.pulls.suggest()
    assert marks.pulls.target == "A"  # C is in focus already


def test_pull_begin_suggests_last_length_where_it_fits(session, marks):
    assert marks.pulls.frames == PULL_FRAMES == 18 and marks.pulls.ease_percent == EASE_PERCENT
    assert marks.pulls.shape is PullShape.EASE
    marks.set_point(LEFT)
    marks.pulls.suggest()
    assert marks.pulls.frames == 18 and marks.pulls.target == "A"
    session.time.timeline.go_to(LAST - 5)
    marks.pulls.suggest()
    assert marks.pulls.frames == 5 and marks.pulls.end_warning == ""
    marks.pulls.target = "gone"
    session.time.timeline.go_to(LAST)
    marks.pulls.suggest()
    assert marks.pulls.frames == 18 and marks.pulls.target == "A"
    assert f"frame {LAST + 18}" in marks.pulls.end_warning and f"{LAST} is the last" in (
        marks.pulls.end_warning
    )
    make_pull(session)
    assert session.messages.text == marks.pulls.end_warning
    session.time.timeline.go_to(LAST - 18)
    assert marks.pulls.end_warning == ""


def test_pull_begin_offers_the_next_mark_in_order(session, marks):
    """The order is that of the names, whichever mark was set last: A, B, C, then A again."""
    marks.set_point(LEFT)
    marks.set_point(RIGHT)
    session.lens.commands.focus(5.0)
    marks.set_here()
    offered_targets = []
    marks.focus_on(session.editing.shot.mark_named("A"))
    marks.pulls.set_length(6)
    for _ in range(3):
        marks.pulls.suggest()
        offered_targets.append(marks.pulls.target)
        make_pull(session)
        session.time.timeline.go_to(session.editing.frame + 6)
    assert offered_targets == ["B", "C", "A"]
    assert [focus_m(session, FIRST + at) for at in (0, 6, 12, 18)] == pytest.approx([2, 8, 5, 2])


def test_pull_begin_off_all_marks_offers_the_newest_then_mark_after_the_last_pull(session, marks):
    marks.set_point(LEFT)
    marks.set_point(RIGHT)
    session.lens.commands.focus(0.3)
    marks.pulls.suggest()
    assert marks.pulls.target == "B"
    make_pull(session)
    session.time.timeline.go_to(FIRST)
    marks.pulls.suggest()
    assert marks.pulls.target == "A"


@pytest.mark.parametrize(
    "focus_offset",
    [
        {"tilt_deg": 2.0, "tilt_direction_deg": 90.0},
        {"split_dioptres": 0.2, "split_direction_deg": 180.0},  # over the left half alone
    ],
)
def test_tilted_or_split_focus_is_set_so_that_the_mark_is_sharp(session, marks, focus_offset):
    """Going to a mark, its flag on the bar and following all use the focus for its own point."""
    marks.set_point(LEFT)
    marks.set_here()
    tilted_lens = replace(session.editing.lens, **focus_offset)
    session.editing.edit_lens(tilted_lens)
    a = session.editing.shot.mark_named("A")
    expected_m = focused_at_pixel(session.source.plate, tilted_lens, *LEFT).focus_distance_m
    assert abs(expected_m - 2.0) > 0.1
    at_point = focus_offset_of(tilted_lens, (WIDTH, HEIGHT)).dioptres_at(*(x + 0.5 for x in LEFT))
    assert 1 / expected_m + at_point == pytest.approx(1 / 2.0)
    session.lens.commands.focus_at(LEFT)
    assert focus_m(session) == pytest.approx(expected_m)
    session.lens.commands.focus(5.0)
    marks.focus_on(a)
    assert focus_m(session) == pytest.approx(expected_m)
    assert dict(session.facts.marks_m) == pytest.approx({"A": expected_m, "B": 4.0})
    assert marks.distances.distance_m(a) == 2.0  # as a tape measures it
    marks.follow(a)
    run_until(session, lambda: session.editing.shot.key_frames, "the keys")
    assert [focus_m(session, at) for at in (FIRST, LAST)] == pytest.approx([expected_m] * 2)


def test_pull_in_a_still_never_reports_a_last_frame(tmp_path):
    session = begin_session(tmp_path / "preferences", str(room_file(tmp_path / "still.exr")))
    run_until_settled(session)
    try:
        marks = session.time.marks
        marks.set_here()
        marks.pulls.suggest()
        assert marks.pulls.end_warning == "" and marks.pulls.frames == 18
        marks.follow(PointMark("A", 3.0, 3.0))
        run_until(session, lambda: not marks.is_reading, "the still")
    finally:
        session.close()


def test_pulls_reverse_swaps_keys_and_hold_keeps_focus(session, marks):
    marks.pulls.reverse()
    assert "two keys" in session.messages.text
    marks.set_point(LEFT)
    marks.pulls.set_length(8)
    make_pull(session)
    ends = focus_m(session, FIRST), focus_m(session, FIRST + 8)
    marks.pulls.reverse()
    assert (focus_m(session, FIRST + 8), focus_m(session, FIRST)) == ends
    marks.pulls.hold_focus()
    keys = session.editing.shot.curves.focus_distance_m.keys
    assert keys[0].interpolation is Interpolation.HOLD
    assert focus_m(session, FIRST + 7) == focus_m(session, FIRST)


def test_follow_sets_focus_keys_over_the_played_frames(session, marks):
    session.time.timeline.go_to(FIRST + 2)
    session.time.timeline.set_in()
    session.time.timeline.go_to(FIRST + 14)
    session.time.timeline.set_out()
    mark = PointMark("A", *map(float, RIGHT))
    marks.follow(mark)
    assert marks.is_reading
    run_until(session, lambda: not marks.is_reading, "all frames")
    frames = [key.frame for key in session.editing.shot.curves.focus_distance_m.keys]
    assert frames == [FIRST + 2, FIRST + 14]  # the wall stands still
    assert focus_m(session, FIRST + 14) == 8.0 and f"from {FIRST + 2} on" in session.messages.text
    session.editing.undo()
    assert not session.editing.shot.key_frames


def test_follow_ends_at_damaged_frame_and_reports_its_name(tmp_path):
    pattern = write_plates(tmp_path)
    (tmp_path / f"walls.{FIRST + 20}.exr").write_bytes(b"damaged")
    session = begin_session(tmp_path / "preferences", pattern)
    run_until_settled(session)
    try:
        marks = session.time.marks
        marks.follow(PointMark("A", *map(float, RIGHT)))
        assert "to follow A" in session.messages.text
        run_until(session, lambda: not marks.is_reading, "the end")
        assert f"walls.{FIRST + 20}.exr" in session.messages.text
        assert not session.editing.shot.key_frames
    finally:
        session.close()


def test_follow_uses_the_frame_before_a_missing_one(tmp_path):
    pattern = write_plates(tmp_path)
    (tmp_path / f"walls.{FIRST + 3}.exr").unlink()
    session = begin_session(tmp_path / "preferences", pattern)
    run_until_settled(session)
    try:
        session.time.marks.follow(PointMark("A", *map(float, LEFT)))
        run_until(session, lambda: not session.time.marks.is_reading, "the end")
        assert focus_m(session, FIRST + 3) == 2.0
        assert session.editing.shot.key_frames == (FIRST, LAST)
    finally:
        session.close()


def test_follow_without_an_open_source_only_reports(tmp_path):
    session = begin_session(tmp_path / "preferences")
    try:
        session.time.marks.follow(PointMark("A", 1.0, 1.0))
        assert "scene" in session.messages.text
    finally:
        session.close()


def test_plates_without_a_camera_in_their_headers_have_no_world(session, marks):
    assert session.source.plate is not None and not marks.anchors.has_world
