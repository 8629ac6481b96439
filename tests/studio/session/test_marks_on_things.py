"""Marks on things of plates: picked by a click, measured on a thread, followed over frames."""

from dataclasses import replace
from threading import Event

import numpy as np
import pytest

from heatlens.core.base.background import wait_for_busy_threads
from heatlens.core.base.errors import InputError
from heatlens.core.model.focus.coc import sharp_dioptres
from heatlens.core.model.marks.marks import MarkAnchor, MatteMark, PointMark, WorldMark
from heatlens.studio.session.marks import surface_tracking
from heatlens.studio.session.marks.matte_light import FLASH_S
from support.evening import begin_session, run_until, run_until_settled
from support.mattes import matte_plate
from support.patience import PATIENCE_S
from support.walks import WALL_M, Walk

FIRST, COUNT = 1, 7
DISTANCES_M = {frame: 3.0 + 0.25 * frame for frame in range(FIRST, FIRST + COUNT)}
HIDDEN = 4


@pytest.fixture
def walk(tmp_path):
    """Return a session with a hero who walks away and is hidden at frame `HIDDEN`."""
    for frame, distance_m in DISTANCES_M.items():
        seen_m = None if frame == HIDDEN else distance_m
        matte_plate(tmp_path / f"walk.{frame:04d}.exr", seen_m)
    session = begin_session(tmp_path / "preferences", str(tmp_path / "walk.####.exr"))
    run_until_settled(session)
    yield session
    session.close()


def set_mark(session, pixel):
    session.time.marks.set_point(pixel)
    run_until(session, lambda: session.editing.shot.marks, "the mark")
    return session.editing.shot.marks[-1]


def test_click_on_matte_object_sets_a_matte_mark(walk):
    hero = set_mark(walk, (14, 10))
    assert hero == MatteMark("hero", "Crypto:hero")
    marks = walk.time.marks
    run_until(walk, lambda: marks.distances.distance_m(hero) is not None, "its distance")
    assert marks.distances.distance_m(hero) == pytest.approx(DISTANCES_M[FIRST], rel=1e-6)
    walk.editing.undo()
    assert walk.editing.shot.marks == ()


def test_second_mark_on_a_thing_has_a_number(walk):
    set_mark(walk, (14, 10))
    walk.time.marks.set_point((14, 10))
    run_until(walk, lambda: len(walk.editing.shot.marks) == 2, "the second mark")
    assert [mark.name for mark in walk.editing.shot.marks] == ["hero", "hero 2"]


def test_click_beside_all_matte_objects_sets_a_point_mark(walk):
    assert set_mark(walk, (2, 2)) == PointMark("A", 2.0, 2.0)


def test_click_after_pick_matte_sets_the_matte_that_is_never_blurred(walk):
    reading = walk.files.commands.reading
    walk.time.marks.pick_matte(reading.change_matte, "never_blur")
    walk.time.marks.set_point((14, 10))
    run_until(walk, lambda: walk.source.plate.cutout is not None, "the cutout")
    assert walk.editing.shot.plate_options.never_blur == "Crypto:hero"
    assert walk.editing.shot.marks == ()
    walk.time.marks.pick_matte(reading.change_matte, "never_blur")
    walk.time.marks.set_point((2, 2))
    run_until(walk, lambda: "Nothing with a matte" in walk.messages.text, "the answer")
    assert isinstance(set_mark(walk, (2, 2)), PointMark)  # the click after it sets a mark


def test_track_of_matte_mark_has_a_gap_where_the_object_is_hidden(walk):
    set_mark(walk, (14, 10))

    def frames():
        (track,) = walk.time.mark_tracks()
        return [frame for line in track.lines for frame, _ in line]

    run_until(walk, lambda: len(frames()) == COUNT - 1, "all frames")
    assert frames() == [frame for frame in DISTANCES_M if frame != HIDDEN]


def test_follow_keeps_focus_on_matte_object_while_it_is_hidden(walk):
    mark = set_mark(walk, (14, 10))
    walk.time.marks.follow(mark)
    run_until(walk, lambda: not walk.time.marks.is_reading, "all frames")
    assert "follows hero" in walk.messages.text
    for frame, distance_m in DISTANCES_M.items():
        lens = walk.editing.shot.lens_at(frame)
        assert abs(1 / lens.focus_distance_m - 1 / distance_m) <= 0.51 * sharp_dioptres(lens)


def test_follow_reports_unknown_matte(walk):
    walk.time.marks.follow(MatteMark("Z", "cryptomatte:nobody"))
    run_until(walk, lambda: not walk.time.marks.is_reading, "the end")
    assert "nobody" in walk.messages.text and not walk.editing.shot.key_frames


@pytest.fixture
def card(tmp_path):
    """Yield a session of plates without ids of objects, and their card, which passes a post."""
    walk = Walk(frames=10, end=(0.4, 0.0, 3.4), post=(150.0, 165.0))
    for frame in range(1, walk.frames + 1):
        walk.write(tmp_path / f"card.{frame:04d}.exr", frame)
    session = begin_session(tmp_path / "preferences", str(tmp_path / "card.####.exr"))
    run_until_settled(session)
    yield session, walk
    session.close()


def click_card(session, walk, frame=1):
    x, y = walk.pixel(frame)
    session.time.marks.set_point((round(x), round(y)))
    return session.editing.shot.marks[-1]


def wait_for_track(session):
    tracking = session.time.marks.anchors.tracking
    run_until(session, lambda: not tracking.is_busy, "the track")
    return session.editing.shot.marks[-1]


def test_click_in_a_sequence_holds_on_to_the_surface_that_focus_follows(card):
    session, walk = card
    marks, tracking = session.time.marks, session.time.marks.anchors.tracking
    point = click_card(session, walk)
    assert MarkAnchor.of(point) is MarkAnchor.PIXEL and tracking.follows(point)
    assert "A is set" in session.messages.text and tracking.words.startswith("Following A, frame")
    mark = wait_for_track(session)
    assert MarkAnchor.of(mark) is MarkAnchor.SURFACE and tracking.words == ""
    assert [place.frame for place in mark.places] == list(range(1, 11))
    assert "surface, seen at" in session.messages.text
    assert marks.distances.distance_m(mark, 10) == pytest.approx(walk.at(10)[2], rel=0.01)
    (track,) = session.time.mark_tracks()
    assert len(track.lines) == 2 == 1 + len(track.bridges)  # hidden in the middle
    marks.follow(mark)
    lens = session.editing.shot.lens_at(10)
    assert abs(1 / lens.focus_distance_m - 1 / walk.at(10)[2]) <= 0.51 * sharp_dioptres(lens)


def test_one_undo_takes_a_tracked_mark_away_whole_whatever_came_meanwhile(card):
    """While it is tracked, the mark is renamed, another is set, and the focus goes elsewhere."""
    session, walk = card
    editing, marks = session.editing, session.time.marks
    point = click_card(session, walk)
    marks.change(point, replace(point, name="hero"))
    marks.set_point((20, 20))
    editing.choose_lens(replace(editing.lens, focus_distance_m=7.0))
    wait_for_track(session)
    undone = []
    for _ in range(4):
        undone.append([(it.name, MarkAnchor.of(it)) for it in editing.shot.marks])
        editing.undo()
    hero, wall = ("hero", MarkAnchor.SURFACE), ("A", MarkAnchor.SURFACE)
    assert undone == [[hero, wall], [hero, wall], [hero], [("A", MarkAnchor.SURFACE)]]
    assert editing.shot.marks == ()


def test_mark_that_cannot_be_tracked_stays_on_the_pixel_and_says_so(card, monkeypatch):
    session, walk = card

    def fail(_cache, _options, frame):
        raise InputError(f"Frame {frame} is damaged.")

    monkeypatch.setattr(surface_tracking, "plate_at", fail)
    click_card(session, walk)
    assert MarkAnchor.of(wait_for_track(session)) is MarkAnchor.PIXEL
    assert session.messages.text == "Mark A stays on the pixel. Frame 1 is damaged."


def test_pull_to_a_mark_waits_until_its_surface_is_known(card):
    session, walk = card
    pulls, editing = session.time.marks.pulls, session.editing
    click_card(session, walk)
    pulls.target, pulls.frames = "A", 9
    assert not pulls.arrival_at.is_known
    pulls.make()
    assert not editing.shot.key_frames
    run_until(session, lambda: editing.shot.key_frames, "the keys of the pull")
    assert editing.shot.lens_at(10).focus_distance_m == pytest.approx(walk.at(10)[2], rel=0.01)


def test_correct_moves_tracked_surface_to_the_clicked_point(card):
    session, walk = card
    marks = session.time.marks
    set_mark(session, (20, 20))
    mark = wait_for_track(session)
    assert marks.distances.distance_m(mark, 10) == pytest.approx(WALL_M)
    session.time.timeline.go_to(10)
    run_until(session, lambda: session.source.is_settled_at(10), "the last frame")
    run_until_settled(session)
    marks.anchors.correct(mark)
    x, y = walk.pixel(10)
    session.time.marks.set_point((round(x), round(y)))
    mark = wait_for_track(session)
    assert [click.frame for click in mark.clicks] == [1, 10]
    assert marks.distances.distance_m(mark, 10) == pytest.approx(walk.at(10)[2], rel=0.01)
    assert len(session.editing.shot.marks) == 1


def write_with_camera(folder, walk, step_m):
    """Write a walk whose camera goes back by `step_m` a frame, along the axis of the world."""
    axes = np.diag([1.0, 1.0, -1.0, 1.0])
    for frame in range(1, walk.frames + 1):
        matrix = np.eye(4)
        matrix[2, 3] = -step_m * frame
        header = {"worldToCamera": np.ascontiguousarray((axes @ matrix).T, np.float32)}
        walk.write(folder / f"card.{frame:04d}.exr", frame, **header)


def test_click_on_what_moves_before_a_known_camera_sets_a_point_mark(tmp_path):
    """The wall stands still; the card moves, which the frames in memory tell."""
    walk = Walk(frames=4)
    write_with_camera(tmp_path, walk, 0.0)
    session = begin_session(tmp_path / "preferences", str(tmp_path / "card.####.exr"))
    for frame in (4, 3, 2, 1):
        session.time.timeline.go_to(frame)
        run_until_settled(session)
        run_until(session, lambda: session.source.is_settled_at(session.editing.frame), "a frame")
    x, y = walk.pixel(1)
    session.time.marks.set_point((round(x), round(y)))
    session.time.marks.set_point((4, 4))
    kinds = [type(mark) for mark in session.editing.shot.marks]
    assert kinds == [PointMark, WorldMark] and "on the place" in session.messages.text
    session.close()


def test_place_turns_point_mark_into_a_world_mark(tmp_path):
    walk = Walk(frames=4)
    write_with_camera(tmp_path, walk, 0.5)
    session = begin_session(tmp_path / "preferences", str(tmp_path / "card.####.exr"))
    run_until_settled(session)
    marks = session.time.marks
    assert marks.anchors.has_world
    marks.anchors.anchor_to(set_mark(session, (20, 20)), MarkAnchor.PLACE)
    (mark,) = session.editing.shot.marks
    assert isinstance(mark, WorldMark)
    marks.anchors.anchor_to(mark, MarkAnchor.PIXEL)
    (point,) = session.editing.shot.marks
    assert isinstance(point, PointMark)
    assert (point.x_px, point.y_px) == pytest.approx((20.0, 20.0), abs=1e-3)
    marks.anchors.anchor_to(point, MarkAnchor.PLACE)
    (mark,) = session.editing.shot.marks
    assert isinstance(mark, WorldMark)
    session.time.timeline.go_to(4)
    run_until_settled(session)
    run_until(
        session,
        lambda: marks.distances.distance_m(mark) == pytest.approx(WALL_M + 1.5),
        "the last frame",
    )
    marks.follow(mark)
    run_until(session, lambda: not marks.is_reading, "all frames")
    assert "follows A" in session.messages.text
    assert session.editing.shot.lens_at(1).focus_distance_m == pytest.approx(WALL_M, rel=0.1)
    session.close()


def test_stopped_tracking_leaves_the_mark_and_reads_no_more_frames(card, monkeypatch):
    session, walk = card
    tracking = session.time.marks.anchors.tracking
    has_read, goes_on, frames = Event(), Event(), []

    def read(_cache, _options, frame):
        frames.append(frame)
        has_read.set()
        assert goes_on.wait(PATIENCE_S)
        return session.source.plate

    monkeypatch.setattr(surface_tracking, "plate_at", read)
    point = click_card(session, walk)
    assert has_read.wait(PATIENCE_S) and tracking.follows(point)
    tracking.stop()
    goes_on.set()
    wait_for_busy_threads()
    run_until_settled(session)
    assert not tracking.is_busy and session.editing.shot.marks == (point,)
    assert len(frames) == 1
    assert session.messages.text == "The tracking is stopped. Mark A stays on the pixel."


def test_matte_of_a_new_mark_is_lit_for_a_moment_and_while_it_is_pointed_at(walk):
    light, now_s = walk.time.marks.light, [10.0]
    light._clock = lambda: now_s[0]
    hero = set_mark(walk, (14, 10))
    run_until(walk, lambda: light.matte is not None, "the light")
    coverage, window = light.matte
    assert coverage.shape == window.shape and 0.0 < coverage.mean() < 1.0
    assert light.seconds_until_needed() == pytest.approx(FLASH_S)
    now_s[0] += FLASH_S
    run_until_settled(walk)
    assert light.matte is None and light.seconds_until_needed() is None
    light.pointed_name = hero.name
    assert light.matte[0] is coverage  # nothing is read again
    walk.time.timeline.go_to(FIRST + 1)
    run_until(
        walk, lambda: light.matte is not None and light.matte[0] is not coverage, "the next frame"
    )
    light.pointed_name = None
    assert light.matte is None
