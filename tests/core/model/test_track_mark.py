"""A mark on a followed surface: typed, corrected, and what is known of it at each frame."""

import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.marks.track_mark import Click, TrackMark, TrackPlace

TYPED = "12,7.5@1001/40,-3@1010"
CLICKS = Click(1001, 12.0, 7.5), Click(1010, 40.0, -3.0)
PLACES = (
    TrackPlace(1001, 12.0, 7.5, 2.0, 1.0),
    TrackPlace(1002, 13.0, 7.5, 2.1, 0.4),
    TrackPlace(1003, 14.0, 7.5),
)


def test_clicks_are_typed_with_their_frames():
    assert TrackMark.typed("eye", TYPED).clicks == CLICKS


@pytest.mark.parametrize("typed", ["", "12,7", "12@1001", "12,7@1001/", "1,2@3/4,5"])
def test_a_place_without_pixel_or_frame_is_refused(typed):
    with pytest.raises(InputError, match="X,Y@FRAME"):
        TrackMark.typed("eye", typed)


def test_there_is_one_click_at_a_frame():
    with pytest.raises(InputError, match="eye"):
        TrackMark("eye", (CLICKS[0], Click(1001, 1.0, 2.0)))
    with pytest.raises(InputError, match="eye"):
        TrackMark("eye", ())


def test_its_places_are_in_the_order_of_frames():
    mark = TrackMark("eye", CLICKS, PLACES)
    assert [mark.distance_at_m(frame) for frame in range(1000, 1004)] == [None, 2.0, 2.1, None]
    assert mark.doubted == [1002]
    for wrong in (PLACES[::-1], (PLACES[0], PLACES[0])):
        with pytest.raises(InputError, match="order"):
            TrackMark("eye", CLICKS, wrong)


def test_a_place_that_nobody_judged_is_doubted():
    assert TrackMark("eye", CLICKS, (TrackPlace(1001, 1.0, 2.0, 3.0),)).doubted == [1001]


def test_a_correction_takes_the_place_of_its_frame_and_is_followed_anew():
    mark = TrackMark("eye", CLICKS, PLACES)
    moved, added = Click(1010, 41.0, -3.0), Click(1005, 20.0, 1.0)
    assert mark.corrected(moved).clicks == (CLICKS[0], moved)
    assert mark.corrected(added) == TrackMark("eye", (CLICKS[0], added, CLICKS[1]))
