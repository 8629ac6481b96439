"""Test marks on a tracked surface: parsing, corrections, and the distance at each frame."""

import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.marks.track_mark import Click, TrackedPoint, TrackMark

TYPED = "12,7.5@1001/40,-3@1010"
CLICKS = Click(frame=1001, x_px=12.0, y_px=7.5), Click(frame=1010, x_px=40.0, y_px=-3.0)
TRACK_PLACES = (
    TrackedPoint(frame=1001, x_px=12.0, y_px=7.5, distance_m=2.0, likeness=1.0),
    TrackedPoint(frame=1002, x_px=13.0, y_px=7.5, distance_m=2.1, likeness=0.4),
    TrackedPoint(frame=1003, x_px=14.0, y_px=7.5),
)


def test_track_mark_typed_parses_clicks_with_frames():
    assert TrackMark.parse("eye", TYPED).clicks == CLICKS


def test_track_mark_tells_its_pixels_and_frames():
    words = TrackMark("eye", CLICKS).location_words(str)
    assert words == "surface at pixel 12,7.5 at 1001 and 40,-3 at 1010"


@pytest.mark.parametrize("typed", ["", "12,7", "12@1001", "12,7@1001/", "1,2@3/4,5"])
def test_track_mark_typed_rejects_click_without_pixel_or_frame(typed):
    with pytest.raises(InputError, match="X,Y@FRAME"):
        TrackMark.parse("eye", typed)


def test_track_mark_rejects_two_clicks_at_one_frame_and_none():
    with pytest.raises(InputError, match="eye"):
        TrackMark("eye", (CLICKS[0], Click(frame=1001, x_px=1.0, y_px=2.0)))
    with pytest.raises(InputError, match="eye"):
        TrackMark("eye", ())


def test_track_mark_looks_up_distances_and_rejects_unordered_places():
    mark = TrackMark("eye", CLICKS, TRACK_PLACES)
    assert [mark.distance_at_m(frame) for frame in range(1000, 1004)] == [None, 2.0, 2.1, None]
    assert mark.doubtful_frames == [1002]
    for wrong in (TRACK_PLACES[::-1], (TRACK_PLACES[0], TRACK_PLACES[0])):
        with pytest.raises(InputError, match="order"):
            TrackMark("eye", CLICKS, wrong)


def test_track_mark_doubts_place_without_confidence():
    assert TrackMark(
        "eye", CLICKS, (TrackedPoint(frame=1001, x_px=1.0, y_px=2.0, distance_m=3.0),)
    ).doubtful_frames == [1001]


def test_add_click_replaces_click_of_frame_and_drops_places():
    mark = TrackMark("eye", CLICKS, TRACK_PLACES)
    moved, added = Click(frame=1010, x_px=41.0, y_px=-3.0), Click(frame=1005, x_px=20.0, y_px=1.0)
    assert mark.add_click(moved).clicks == (CLICKS[0], moved)
    assert mark.add_click(added) == TrackMark("eye", (CLICKS[0], added, CLICKS[1]))
