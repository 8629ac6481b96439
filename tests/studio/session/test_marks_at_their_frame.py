"""The distance of a mark is measured on its own frame, whichever frames are in memory."""

from contextlib import contextmanager
from threading import Event

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from heatlens.media.frame_cache.cache import FrameCache
from heatlens.studio.session.marks import mark_distances
from support.evening import (
    HEIGHT,
    WIDTH,
    begin_session,
    run_loop_once,
    run_until,
    run_until_settled,
)
from support.exr_files import write_file
from support.patience import PATIENCE_S

FIRST, LAST, POINT = 1001, 1030, (8, 16)


def wall_m(frame):
    """Return the distance of the wall at this frame; the wall comes nearer by 0.1 m a frame."""
    return 4.0 - 0.1 * (frame - FIRST)


def focus_m(session, frame):
    return session.editing.shot.lens_at(frame).focus_distance_m


def write_wall(folder):
    grey = np.full((HEIGHT, WIDTH), 0.18, np.float16)
    for frame in range(FIRST, LAST + 1):
        depth = np.full((HEIGHT, WIDTH), wall_m(frame), np.float32)
        write_file(folder / f"wall.{frame}.exr", {"R": grey, "G": grey, "B": grey, "Z": depth})
    return str(folder / "wall.####.exr")


@pytest.fixture
def wall(tmp_path):
    session = begin_session(tmp_path / "preferences", write_wall(tmp_path))
    run_until_settled(session)
    session.time.marks.set_point(POINT)
    yield session
    session.close()


@contextmanager
def hide_frames(hidden):
    """Make the cache of frames answer as if the `hidden` frames were not read yet."""
    get = FrameCache.get
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            FrameCache, "get", lambda it, frame: None if frame in hidden else get(it, frame)
        )
        yield


def wait_for_distance(session):
    run_until(session, lambda: not session.time.marks.distances.has_request, "the distance")


frames = st.integers(FIRST, LAST)


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(frames, frames, st.integers(1, 29), st.sets(frames), st.booleans())
def test_mark_distance_is_measured_on_the_frame_it_is_used_at(
    wall, seen, start, length, hidden, is_from_a
):
    """`distance_m`, `focus_on` and pulls measure it, from any frame, with any frames unread."""
    marks, (mark,) = wall.time.marks, wall.editing.shot.marks
    wall.time.timeline.go_to(seen)
    run_until_settled(wall)
    shot_before = wall.editing.shot
    wall.time.timeline.go_to(start)
    arrival = min(start + length, LAST)
    with hide_frames(hidden):
        run_loop_once(wall)
        assert marks.distances.distance_m(mark) in (None, pytest.approx(wall_m(start)))
        assert marks.distances.distance_m(mark, arrival) in (None, pytest.approx(wall_m(arrival)))
        marks.focus_on(mark)
        wait_for_distance(wall)
        assert focus_m(wall, start) == pytest.approx(wall_m(start), rel=1e-5)
        marks.pulls.origin, marks.pulls.target = "A" if is_from_a else None, "A"
        marks.pulls.frames = length
        marks.pulls.make()
        wait_for_distance(wall)
    assert focus_m(wall, start + length) == pytest.approx(wall_m(arrival), rel=1e-5)
    wall.editing.do(shot_before)


def test_pull_box_shows_arrival_distance_once_it_is_measured(wall):
    marks = wall.time.marks
    marks.pulls.suggest()
    assert marks.pulls.arrival == FIRST + 18
    assert not marks.pulls.arrival_at.is_known and marks.pulls.arrival_at.distance_m is None
    run_until(wall, lambda: marks.pulls.arrival_at.is_known, "the distance")
    assert marks.pulls.arrival_at.distance_m == pytest.approx(wall_m(FIRST + 18), rel=1e-5)
    marks.pulls.make()
    assert not marks.distances.has_request  # what the box told is taken
    assert focus_m(wall, FIRST + 18) == pytest.approx(wall_m(FIRST + 18), rel=1e-5)


def test_pull_to_unreadable_frame_reports_and_sets_no_key(wall, tmp_path):
    marks, damaged = wall.time.marks, tmp_path / f"wall.{FIRST + 18}.exr"
    damaged.write_bytes(damaged.read_bytes()[:300])
    before = wall.editing.shot
    marks.pulls.suggest()
    marks.pulls.make()
    wait_for_distance(wall)
    assert wall.editing.shot == before and marks.pulls.pull_count == 0
    assert damaged.name in wall.messages.text and f"frame {FIRST + 18}" in wall.messages.text


def test_pull_waiting_for_a_frame_of_a_closed_source_sets_no_key(wall, tmp_path, monkeypatch):
    marks, is_opened, read = wall.time.marks, Event(), mark_distances.read_plate

    def read_late(path, options):
        assert is_opened.wait(PATIENCE_S)
        return read(path, options)

    monkeypatch.setattr(mark_distances, "read_plate", read_late)
    (tmp_path / "other").mkdir()
    marks.pulls.suggest()
    with hide_frames({FIRST + 18}):  # reading ahead must not answer the request first
        marks.pulls.make()
        assert marks.distances.has_request
        other = write_wall(tmp_path / "other")
        wall.files.commands.open(other)
        run_until(wall, lambda: wall.source.opened.text == other, "the other wall")
        run_until_settled(wall)
    is_opened.set()
    wait_for_distance(wall)
    assert marks.pulls.pull_count == 0 and not wall.editing.shot.curves.focus_distance_m.keys


def test_mark_is_not_set_or_tracked_before_its_frame_is_read(wall):
    marks, before = wall.time.marks, wall.editing.shot
    with hide_frames({FIRST + 5}):
        wall.time.timeline.go_to(FIRST + 5)
        run_loop_once(wall)
        marks.set_point(POINT)
        marks.anchors.track(before.marks[0], before.marks[0])
        marks.anchors.fix_in_world(before.marks[0], before.marks[0])
        assert wall.editing.shot == before and not marks.is_reading
        assert str(FIRST + 5) in wall.messages.text
    run_until_settled(wall)
    marks.set_point(POINT)
    assert len(wall.editing.shot.marks) == 2
