"""Frames rendered ahead: their keys, their order, and the work of FrameFiller and StampBook."""

import time
from dataclasses import replace
from inspect import GEN_CLOSED, getgeneratorstate
from itertools import pairwise
from math import inf
from threading import Event, current_thread

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.camera_track import Pose
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.pull import pull
from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.read import read_plate
from heatlens.media.sequence.sequence import StampedFile, stamp_files, stamp_of
from heatlens.render.rendered_frames.cached_pictures import to_half
from heatlens.render.rendered_frames.frame_filler import FrameFiller, FrameJob, PlateFile
from heatlens.render.rendered_frames.frame_key import (
    KeySource,
    PlayOrder,
    SceneSight,
    frame_key,
    maker_of,
    program_digest,
    runs_of,
    shot_key,
)
from heatlens.render.rendered_frames.stamp_book import StampBook
from support.patience import PATIENCE_S
from support.session_files import LENS, room_file

SOURCE = KeySource("/plates/a.exr", ((5, 7),))
SIGHT = SceneSight(pose=Pose(), moment=3.0, size=(96, 54))
DRAFT = DefocusSettings(quality=Quality.DRAFT, proxy=0.5)
HALF_SHAPE = (32, 48, 4)  # of a picture of 96 x 64 pixels, blurred with DRAFT


def key(shot: Shot, frame: int) -> str:
    together = shot_key(("maker",), shot.plate_options, shot.defocus)
    return frame_key(together, SOURCE, shot.lens_at(frame))


@pytest.mark.parametrize(
    "changed",
    [
        replace(LENS, f_stop=1.1),
        replace(LENS, focus_distance_m=2.0001),
        replace(LENS, focal_length_mm=84.0),
        replace(LENS, sensor_width_mm=35.0),
        replace(LENS, squeeze=1.5),
    ],
)
def test_frame_key_changes_with_lens(changed):
    assert frame_key("shot", SOURCE, changed) != frame_key("shot", SOURCE, LENS)


@pytest.mark.parametrize("advice", ["acceptable_coc_mm", "close_focus_m", "t_stop"])
def test_frame_key_ignores_lens_fields_without_effect_on_pixels(advice):
    lens = replace(LENS, **{advice: 1.5})
    assert frame_key("shot", SOURCE, lens) == frame_key("shot", SOURCE, LENS)


def test_frame_key_changes_with_shot_source_and_scene_sight():
    keys = {
        frame_key("shot", SOURCE, LENS),
        frame_key("other", SOURCE, LENS),
        frame_key("shot", replace(SOURCE, name="/plates/b.exr"), LENS),
        frame_key("shot", replace(SOURCE, stamps=((6, 7),)), LENS),
        frame_key("shot", SOURCE, LENS, SIGHT),
        frame_key("shot", SOURCE, LENS, replace(SIGHT, moment=4.0)),
        frame_key("shot", SOURCE, LENS, replace(SIGHT, moment=None)),
        frame_key("shot", SOURCE, LENS, replace(SIGHT, size=(96, 55))),
        frame_key("shot", SOURCE, LENS, replace(SIGHT, pose=Pose((0.0, 0.0, 1.0)))),
    }
    assert len(keys) == 9


def test_shot_key_changes_with_maker_options_and_settings(ctx, renderer):
    keys = {
        shot_key(("a",), PlateOptions(), DRAFT),
        shot_key(("b",), PlateOptions(), DRAFT),
        shot_key(("a",), PlateOptions(depth_channel="Z"), DRAFT),
        shot_key(("a",), PlateOptions(), replace(DRAFT, proxy=0.75)),
        shot_key(("a",), PlateOptions(), replace(DRAFT, layers=2)),
    }
    assert len(keys) == 5
    assert program_digest() in maker_of(renderer)


@given(st.integers(0, 3), st.floats(0.5, 20.0))
def test_frame_key_changes_only_where_a_moved_key_reaches(index, distance_m):
    """Change one of four keys at frames 1, 13, 25 and 37, and compare the frame keys."""
    key_frames = (1, 13, 25, 37)
    shot = Shot(LENS)
    for frame, metres in zip(key_frames, (2.0, 5.0, 3.0, 8.0), strict=True):
        shot = shot.with_key(frame, LensParameter.FOCUS_DISTANCE, metres)
    changed_shot = shot.with_key(key_frames[index], LensParameter.FOCUS_DISTANCE, distance_m)
    # A smooth path at the keys beside it follows it too, and so one span more on either side.
    low = -inf if index == 0 else key_frames[max(index - 2, 0)]
    high = inf if index == 3 else key_frames[min(index + 2, 3)]
    for frame in range(-5, 60):
        if not low < frame < high:
            assert key(shot, frame) == key(changed_shot, frame)
        if shot.lens_at(frame) != changed_shot.lens_at(frame):
            assert key(shot, frame) != key(changed_shot, frame)


@given(
    st.integers(-50, 50), st.integers(1, 40), st.integers(-60, 60), st.sampled_from((1, -1)),
    st.integers(1, 60),
)  # fmt: skip
def test_play_order_starts_at_playhead_and_has_each_frame_once(
    first, count, playhead, direction, most
):
    played = FrameRange(first, first + count - 1)
    order = PlayOrder(playhead, direction, played, most).frames
    assert len(order) == len(set(order)) == min(most, count)
    assert set(order) <= set(played)
    start = playhead if playhead in played else (played.first if direction > 0 else played.last)
    assert order[0] == start
    for frame, following in pairwise(order):
        assert (following - frame - direction) % count == 0


@given(st.frozensets(st.integers(-30, 30)))
def test_runs_of_covers_frames_without_adjacent_runs(frames):
    runs = runs_of(frames)
    assert [frame for run in runs for frame in run] == sorted(frames)
    assert all(b.first > a.last + 1 for a, b in pairwise(runs))


def fill_frame(filler: FrameFiller, job: FrameJob, slice_s: float = 10.0):
    """Return the picture of a job, rendered in slices of this length."""
    for _ in range(100_000):
        picture = filler.work(job, None, slice_s)
        if picture is not None:
            return picture
        time.sleep(0.001 if filler.is_reading else 0.0)
    raise AssertionError("the frame never came")


@pytest.fixture
def filler(ctx, renderer):
    frame_filler = FrameFiller(renderer.make_sibling())
    yield frame_filler
    frame_filler.close()


def job_of(path, frame: int = 4, key: str = "k") -> FrameJob:
    shot = pull(Shot(LENS, DRAFT), 2.0, 5.0, 1, 8)
    return FrameJob(key, shot, frame, PlateFile(stamp_files((path,)), PlateOptions(), read_plate))


def test_frame_rendered_ahead_equals_renderer_in_half_floats(filler, renderer, tmp_path):
    path = room_file(tmp_path / "room.exr")
    renderer.load(read_plate(path))
    for frame in (1, 4, 9):
        job = job_of(path, frame, f"k{frame}")
        picture = fill_frame(filler, job).as_kept()
        assert picture.pixels.shape == HALF_SHAPE  # its windows stay those of the plate
        np.testing.assert_array_equal(picture.pixels, to_half(renderer.pixels(job.shot, frame)))
        assert (picture.data_window.width, picture.display_window.height) == (96, 64)


def test_frame_rendered_ahead_in_short_slices_equals_renderer(filler, renderer, tmp_path):
    path = room_file(tmp_path / "room.exr")
    ticks = iter(range(10**9))
    filler._clock = lambda: float(next(ticks))
    picture = fill_frame(filler, job_of(path), 0.5).as_kept()
    renderer.load(read_plate(path))
    expected = to_half(renderer.pixels(job_of(path).shot, 4))
    np.testing.assert_array_equal(picture.pixels, expected)


def test_filler_renders_same_picture_after_other_job_and_unload(filler, renderer, tmp_path):
    first_path, second_path = (
        room_file(tmp_path / "one.exr"),
        room_file(tmp_path / "two.exr", 80, 48),
    )
    ticks = iter(range(10**9))
    filler._clock = lambda: float(next(ticks))
    for _ in range(50):
        filler.work(job_of(first_path), job_of(second_path, key="2"), 2.0)
    renderer.load(read_plate(second_path))
    expected = to_half(renderer.pixels(job_of(second_path).shot, 4))
    for _ in range(2):
        picture = fill_frame(filler, job_of(second_path, key="2"), 3.0).as_kept()
        np.testing.assert_array_equal(picture.pixels, expected)
        filler.unload()


def test_other_job_and_unload_close_steps_of_earlier_job(filler, tmp_path):
    """Check that the generator is closed even while something, like a traceback, refers to it."""
    path = room_file(tmp_path / "room.exr")
    for end in (lambda: filler.work(job_of(path, key="2"), None, 0.0), filler.unload):
        filler.work(job_of(path), None, 0.0)
        before = filler._steps
        end()
        assert getgeneratorstate(before) == GEN_CLOSED


def test_fill_rejects_plate_changed_since_its_stamp(filler, tmp_path):
    path = room_file(tmp_path / "room.exr")
    job = job_of(path)
    room_file(path, 80, 48)
    with pytest.raises(InputError, match=r"room\.exr has changed"):
        fill_frame(filler, job)


def test_fill_rejects_damaged_plate_and_renders_next(filler, tmp_path):
    bad, good = tmp_path / "bad.exr", room_file(tmp_path / "good.exr")
    bad.write_bytes(b"no picture")
    with pytest.raises(InputError, match=r"bad\.exr"):
        fill_frame(filler, job_of(bad))
    assert fill_frame(filler, job_of(good, key="2")).pixels.shape == HALF_SHAPE


def test_stamp_book_stamps_files_and_wakes_on_change(tmp_path):
    wake_calls = []
    book = StampBook(lambda: wake_calls.append(True))
    path, gone = room_file(tmp_path / "room.exr"), tmp_path / "gone.exr"
    files = {1: (path, gone), 2: ()}
    assert book.files(1) is None
    states = [book.latest]
    for count, change in (
        (1, lambda: None),
        (1, lambda: None),
        (2, lambda: path.write_bytes(b"x")),
    ):
        change()
        book.start_look_up(files, files.__getitem__)
        book._pending.result()
        assert book.files(1) == (StampedFile(path, stamp_of(path)), StampedFile(gone, None))
        assert book.files(2) == () and book.files(3) is None
        states += [book.latest] if book.latest is not states[-1] else []
        assert len(states) == count + 1 and len(wake_calls) == count
    book.close()


def test_stamp_book_looks_up_on_thread_and_drops_forgotten_source(tmp_path):
    """Check that a folder that does not answer blocks no reader, and its late answer is dropped."""
    answers, threads, path = Event(), [], tmp_path / "a.exr"

    def files_at(_frame):
        threads.append(current_thread())
        assert answers.wait(PATIENCE_S)
        return (path,)

    book = StampBook()
    book.start_look_up([1, 2], files_at)
    late = book._pending
    assert book.files(1) is None
    book.forget()
    book.start_look_up([1], lambda _frame: ())  # of another source, whose folder answers
    book._pending.result(PATIENCE_S)
    assert book.files(1) == () and not answers.is_set()
    answers.set()
    late.result(PATIENCE_S)
    assert book.files(1) == ()
    assert threads and current_thread() not in threads
    book.close()
