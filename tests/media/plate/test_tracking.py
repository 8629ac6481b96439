"""A tracked surface: found on each frame, also after it was hidden, on plates of known motion."""

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.coc import sharp_dioptres
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.track_mark import Click, TrackMark
from heatlens.media.plate.tracking.tracked_mark import tracked
from support.walks import WALL_M, Walk

LENS = Lens(focal_length_mm=50, f_stop=1.4, focus_distance_m=3, sensor_width_mm=36)


def places_of(walk, *click_frames, off=(0.0, 0.0)):
    clicks = []
    for frame in click_frames:
        x, y = walk.pixel(frame)
        clicks.append(Click(frame, x + off[0], y + off[1]))
    mark = TrackMark("A", tuple(clicks))
    found = tracked(mark, FrameRange(1, walk.frames), walk.plate, lambda words: None)
    assert [place.frame for place in found.places] == list(range(1, walk.frames + 1))
    return found.places


def part_within_a_quarter(walk, places):
    """Return the share of the frames whose focus is within a quarter of the sharp range."""
    seen = [place for place in places if place.distance_m is not None]
    good = 0
    for place in seen:
        sharp = sharp_dioptres(LENS)
        good += abs(1 / place.distance_m - 1 / walk.at(place.frame)[2]) < sharp / 4
    return good / len(seen)


WALKS = {
    "farther": Walk(),
    "nearer": Walk(start=(0.6, -0.1, 4.0), end=(-0.3, 0.0, 1.6)),
    "fast across": Walk(frames=12, start=(-1.0, 0.0, 3.0), end=(1.0, 0.1, 3.2)),
    "with grain": Walk(grain=0.04),
    "without a pattern": Walk(is_plain=True),
}


@pytest.mark.parametrize("name", WALKS)
@pytest.mark.parametrize("click", ["first", "middle", "last"])
def test_a_surface_is_followed_forwards_and_backwards(name, click):
    walk = WALKS[name]
    frame = {"first": 1, "middle": walk.frames // 2, "last": walk.frames}[click]
    places = places_of(walk, frame)
    assert all(place.distance_m is not None for place in places)
    assert part_within_a_quarter(walk, places) >= 0.95
    if not walk.is_plain:
        off = [
            np.hypot(p.x_px - walk.pixel(p.frame)[0], p.y_px - walk.pixel(p.frame)[1])
            for p in places
        ]
        assert np.median(off) < 3.0


@pytest.mark.parametrize("click", [1, 24])
@pytest.mark.parametrize("grain", [0.0, 0.03])
def test_a_hidden_surface_is_told_and_found_where_it_comes_out(click, grain):
    walk = Walk(post=(160.0, 190.0), grain=grain)
    places = places_of(walk, click)
    hidden = {frame for frame in range(1, 25) if walk.is_hidden(frame)}
    told = {place.frame for place in places if place.distance_m is None}
    assert hidden and part_within_a_quarter(walk, places) >= 0.95
    # nobody calls the post the card, and it is found again within a few frames
    assert all(p.distance_m is None or p.distance_m > 2.5 for p in places)
    assert hidden & told and len(told - hidden) <= 8
    assert places[0].distance_m is not None and places[-1].distance_m is not None


def test_a_correction_is_the_place_and_the_track_goes_on_from_there():
    walk = Walk()
    frames = FrameRange(1, walk.frames)
    wall = TrackMark("A", (Click(1, 20.0, 20.0),))  # beside the card
    found = tracked(wall, frames, walk.plate, lambda words: None)
    assert {round(place.distance_m, 3) for place in found.places} == {WALL_M}
    mended = found.corrected(Click(8, *walk.pixel(8)))
    assert mended.places == () and len(mended.clicks) == 2
    found = tracked(mended, frames, walk.plate, lambda words: None)
    after = [place for place in found.places if place.frame >= 8]
    assert part_within_a_quarter(walk, after) == 1.0
    assert found.place_at(1).distance_m == pytest.approx(WALL_M)


@pytest.mark.parametrize(
    ("click", "told"),
    [(Click(99, 10, 10), "99"), (Click(1, 5000, 10), "5000"), (Click(2, 10, 10), "sky")],
)
def test_what_cannot_be_tracked_is_refused(click, told):
    def plate_at(frame):
        plate = Walk().plate(frame)
        if frame == 2:
            plate.depth_m[:] = np.inf
        return plate

    with pytest.raises(InputError, match=told):
        tracked(TrackMark("A", (click,)), FrameRange(1, 3), plate_at, lambda words: None)


def test_out_of_the_picture_it_is_held_and_told():
    walk = Walk(start=(0.0, 0.0, 3.0), end=(3.5, 0.0, 3.0))
    places = places_of(walk, 1)
    assert places[0].distance_m is not None and places[-1].distance_m is None
    assert part_within_a_quarter(walk, places) == 1.0
