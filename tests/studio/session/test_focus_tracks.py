"""What the timeline draws of the focus and of marks, in dioptres at each frame."""

import numpy as np
import pytest

from heatlens.core.model.curves.curve import Curve, Key
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.curves.interpolation import Scale
from heatlens.core.model.focus.coc import far_limit_m, near_limit_m
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.marks import DistanceMark, ObjectMark, PointMark
from heatlens.core.model.shot.focus_track import FocusTrack
from heatlens.core.model.shot.lens_parameter import FOCUS_SCALES, LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.media.frame_cache.frame_states import Run
from heatlens.studio.session.time.focus_track import MarkTracks, MatteDistances, mark_m
from support.evening import FIRST, LEFT, RIGHT, run_until
from support.plates import plate_of

FOCUS, FOCAL = LensParameter.FOCUS_DISTANCE, LensParameter.FOCAL_LENGTH
SHOT = Shot(Lens(50.0, 2.8, 2.0, 36.0, close_focus_m=1.0))


def test_focus_track_samples_evenly_and_at_each_key():
    shot = SHOT.with_key(3.3, FOCUS, 2.0).with_key(8, FOCUS, 4.0).with_key(99, FOCUS, 4.0)
    track = FocusTrack()
    samples = track.samples(shot, 0, 10, 5)
    assert [sample.frame for sample in samples] == [0, 2.5, 3.3, 5, 7.5, 8, 10]
    for sample in samples:
        lens = shot.lens_at(sample.frame)
        assert sample.focus == pytest.approx(1 / lens.focus_distance_m)
        assert sample.near == pytest.approx(1 / near_limit_m(lens))
        assert sample.far == pytest.approx(1 / far_limit_m(lens))
        assert sample.far < sample.focus < sample.near
    assert track.samples(shot, 0, 10, 5) is samples
    assert track.samples(shot, 0, 10, 6) is not samples


def test_focus_track_puts_impossible_lens_at_infinity():
    far = Curve((Key(0, 2.0), Key(20, 2.0)), FOCUS_SCALES["dioptres"])
    zoom = Curve((Key(0, 50.0), Key(20, 2500.0)), Scale.LOGARITHMIC)
    shot = SHOT.with_curve(FOCAL, zoom).with_curve(FOCUS, far)
    last = FocusTrack().samples(shot, 0, 20, 2)[-1]
    assert (last.focus, last.near, last.far) == (0.0, 0.0, 0.0)
    assert FocusTrack().too_close_frames(shot, FrameRange(0, 20)) == ()


def test_too_close_frames_lists_frames_nearer_than_the_close_focus():
    shot = SHOT.with_key(0, FOCUS, 2.0).with_key(10, FOCUS, 0.5)
    track = FocusTrack()
    warned_frames = track.too_close_frames(shot, FrameRange(0, 10))
    assert warned_frames and warned_frames[-1] == 10 and 0 not in warned_frames
    assert all(shot.lens_at(frame).focus_distance_m < 1.0 for frame in warned_frames)
    assert track.too_close_frames(shot, FrameRange(0, 10)) is warned_frames
    assert track.too_close_frames(shot, FrameRange(0, 0)) == ()
    assert 10 in track.too_close_frames(shot, FrameRange(0, 1999))
    assert track.too_close_frames(shot, FrameRange(0, 2000)) == ()


def test_mark_m_measures_point_mark_on_its_plate():
    depth = np.full((4, 6), 2.0, np.float32)
    depth[:, 3:] = 8.0
    plate = plate_of(np.ones((4, 6, 3), np.float32), depth)
    assert mark_m(plate, DistanceMark("A", 3.5)) == 3.5 == mark_m(None, DistanceMark("A", 3.5))
    assert mark_m(plate, PointMark("B", 1.9, 2.0)) == 2.0
    assert mark_m(plate, PointMark("B", 5.9, 3.9)) == 8.0
    assert mark_m(None, PointMark("B", 1.0, 1.0)) is None
    assert mark_m(plate, ObjectMark("C", "cube")) is None
    assert mark_m(plate, PointMark("B", 60.0, 1.0)) is None


def test_mark_tracks_cover_the_frames_in_memory(session):
    for pixel in (LEFT, RIGHT):
        session.time.marks.set_point(pixel)
    session.time.marks.set_here()
    timeline = session.time.timeline
    last = FIRST + 7
    run_until(session, lambda: timeline.cache.get(last) is not None, "eight frames")
    near, far = session.time.mark_tracks()
    assert (near.name, far.name) == ("A", "B")
    for track, distance_m in ((near, 2.0), (far, 8.0)):
        (line,) = track.lines
        assert line[:8] == tuple((frame, 1 / distance_m) for frame in range(FIRST, last + 1))
    assert session.time.mark_tracks() == (near, far)


def test_mark_track_has_gaps_where_frames_are_not_in_memory(session):
    tracks, cache = MarkTracks(MatteDistances(lambda: None)), session.time.timeline.cache
    run_until(session, lambda: cache.get(FIRST + 3) is not None, "some frames")
    marks = (PointMark("A", *map(float, LEFT)), DistanceMark("B", 3.0))
    assert tracks.tracks(None, (), marks) == ()
    runs = (
        Run(first=FIRST, last=FIRST + 1, state="ready"),
        Run(first=FIRST + 2, last=FIRST + 2, state="waiting"),
    )
    runs = (*runs, Run(first=FIRST + 3, last=FIRST + 3, state="ready"))
    (track,) = tracks.tracks(cache, runs, marks)
    assert [[frame for frame, _ in line] for line in track.lines] == [
        [FIRST, FIRST + 1], [FIRST + 3],
    ]  # fmt: skip
    outside = (PointMark("A", 1e4, 1e4),)
    assert tracks.tracks(cache, runs, outside)[0].lines == ()
