"""Test tracking of a surface over frames of known motion, also after it was hidden."""

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.coc import sharp_dioptres
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.track_mark import Click, TrackMark
from heatlens.media.plate.tracking.tracked_mark import track_mark
from support.walks import WALL_M, Walk

LENS = Lens(focal_length_mm=50, f_stop=1.4, focus_distance_m=3, sensor_width_mm=36)


def track_walk(walk, *click_frames, offset_px=(0.0, 0.0)):
    clicks = []
    for frame in click_frames:
        x, y = walk.pixel(frame)
        clicks.append(Click(frame, x_px=x + offset_px[0], y_px=y + offset_px[1]))
    mark = TrackMark("A", tuple(clicks))
    track = track_mark(mark, FrameRange(1, walk.frames), walk.plate, lambda words: None)
    assert [place.frame for place in track.places] == list(range(1, walk.frames + 1))
    return track.places


def share_within_quarter_of_sharp_range(walk, places):
    """Return the share of the frames whose focus is within a quarter of the sharp range."""
    visible_places = [place for place in places if place.distance_m is not None]
    good_count = 0
    for place in visible_places:
        sharp_range = sharp_dioptres(LENS)
        good_count += abs(1 / place.distance_m - 1 / walk.at(place.frame)[2]) < sharp_range / 4
    return good_count / len(visible_places)


WALKS = {
    "farther": Walk(),
    "nearer": Walk(start=(0.6, -0.1, 4.0), end=(-0.3, 0.0, 1.6)),
    "fast across": Walk(frames=12, start=(-1.0, 0.0, 3.0), end=(1.0, 0.1, 3.2)),
    "with grain": Walk(grain=0.04),
    "without a pattern": Walk(is_plain=True),
}


@pytest.mark.parametrize("name", WALKS)
@pytest.mark.parametrize("click", ["first", "middle", "last"])
def test_tracked_follows_surface_forward_and_backward(name, click):
    walk = WALKS[name]
    frame = {"first": 1, "middle": walk.frames // 2, "last": walk.frames}[click]
    places = track_walk(walk, frame)
    assert all(place.distance_m is not None for place in places)
    assert share_within_quarter_of_sharp_range(walk, places) >= 0.95
    if not walk.is_plain:
        errors_px = [
            np.hypot(p.x_px - walk.pixel(p.frame)[0], p.y_px - walk.pixel(p.frame)[1])
            for p in places
        ]
        assert np.median(errors_px) < 3.0


@pytest.mark.parametrize("click", [1, 24])
@pytest.mark.parametrize("grain", [0.0, 0.03])
def test_tracked_reports_hidden_frames_and_finds_surface_again(click, grain):
    walk = Walk(post=(160.0, 190.0), grain=grain)
    places = track_walk(walk, click)
    hidden = {frame for frame in range(1, 25) if walk.is_hidden(frame)}
    reported_hidden = {place.frame for place in places if place.distance_m is None}
    assert hidden and share_within_quarter_of_sharp_range(walk, places) >= 0.95
    # nobody calls the post the card, and it is found again within a few frames
    assert all(p.distance_m is None or p.distance_m > 2.5 for p in places)
    assert hidden & reported_hidden and len(reported_hidden - hidden) <= 8
    assert places[0].distance_m is not None and places[-1].distance_m is not None


def test_tracked_continues_from_corrected_click():
    walk = Walk()
    frames = FrameRange(1, walk.frames)
    wall_mark = TrackMark("A", (Click(frame=1, x_px=20.0, y_px=20.0),))  # beside the card
    track = track_mark(wall_mark, frames, walk.plate, lambda words: None)
    assert {round(place.distance_m, 3) for place in track.places} == {WALL_M}
    corrected_mark = track.add_click(Click(8, *walk.pixel(8)))
    assert corrected_mark.places == () and len(corrected_mark.clicks) == 2
    track = track_mark(corrected_mark, frames, walk.plate, lambda words: None)
    later_places = [place for place in track.places if place.frame >= 8]
    assert share_within_quarter_of_sharp_range(walk, later_places) == 1.0
    assert track.point_at(1).distance_m == pytest.approx(WALL_M)


@pytest.mark.parametrize(
    ("click", "message_part"),
    [(Click(99, 10, 10), "99"), (Click(1, 5000, 10), "5000"), (Click(2, 10, 10), "sky")],
)
def test_tracked_rejects_impossible_clicks(click, message_part):
    def plate_at(frame):
        plate = Walk().plate(frame)
        if frame == 2:
            plate.depth_m[:] = np.inf
        return plate

    with pytest.raises(InputError, match=message_part):
        track_mark(TrackMark("A", (click,)), FrameRange(1, 3), plate_at, lambda words: None)


def test_tracked_reports_frames_outside_the_image():
    walk = Walk(start=(0.0, 0.0, 3.0), end=(3.5, 0.0, 3.0))
    places = track_walk(walk, 1)
    assert places[0].distance_m is not None and places[-1].distance_m is None
    assert share_within_quarter_of_sharp_range(walk, places) == 1.0
