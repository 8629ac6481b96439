"""How much overscan a lens needs, against the radius of a disc as a formula gives it."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.boxes import Box
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.media.plate.overscan_need import overscan_need, overscan_px
from support.plates import coc_plate_of, plate_of

LENS = Lens(50.0, 2.0, 2.0, 36.0)
COLOR = np.ones((54, 96, 4), np.float32)


def plate(near_m: float, far_m: float, margin: int = 0):
    depth_m = np.full((54, 96), far_m, np.float32)
    depth_m[:, :10] = near_m
    made = plate_of(COLOR, depth_m)
    shown = made.data_window
    box = Box(shown.x0 + margin, shown.y0 + margin, shown.x1 - margin, shown.y1 - margin)
    return replace(made, display_window=box)


def radius_px(depth_m: float, focus_m: float, width_px: int) -> float:
    """Return A f / (S - f) |1 - S / z| on the sensor, in pixels."""
    f_m, opening_m = 0.05, 0.025
    disc_m = opening_m * f_m / (focus_m - f_m) * abs(1 - focus_m / depth_m)
    return disc_m / 0.036 * width_px / 2


@pytest.mark.parametrize(("near_m", "far_m", "widest_m"), [(0.5, 3.0, 0.5), (1.9, 50.0, 50.0)])
def test_the_widest_disc_is_that_of_the_nearest_or_the_farthest(near_m, far_m, widest_m):
    need = overscan_need(plate(near_m, far_m), {1001: LENS})
    assert need.needed_px == pytest.approx(radius_px(widest_m, 2.0, 96), rel=1e-6)
    assert (need.at_frame, need.has_px) == (1001, 0)


def test_a_squeezed_disc_reaches_as_far_as_its_longer_side():
    plain, squeezed = (
        overscan_need(plate(0.5, 3.0), {1: replace(LENS, squeeze=squeeze)}) for squeeze in (1, 2)
    )
    assert squeezed.needed_px == pytest.approx(plain.needed_px)


def test_frames_that_need_more_are_named_in_runs():
    f_stops = {frame: 8.0 for frame in range(1, 9)} | {3: 0.7, 4: 0.7, 7: 0.7}
    lenses = {frame: replace(LENS, f_stop=f_stop) for frame, f_stop in f_stops.items()}
    need = overscan_need(plate(0.5, 3.0, margin=3), lenses)
    assert need.short == (FrameRange(3, 4), FrameRange(7, 7))
    assert "the plate has 3 px, too few for the borders of 3-4, 7." in need.sentence
    assert "with 8 px" in need.sentence


def test_enough_is_told_without_a_wish():
    need = overscan_need(plate(0.9, 3.0, margin=8), {1: replace(LENS, f_stop=16.0)})
    assert not need.short and need.sentence.endswith("the plate has 8 px.")


def test_a_plate_of_circles_of_confusion_tells_nothing():
    assert overscan_need(coc_plate_of(COLOR, np.ones((54, 96), np.float32)), {1: LENS}) is None
    assert overscan_need(plate(1.0, 2.0), {}) is None


def test_the_side_with_the_least_counts():
    made = plate(1.0, 2.0)
    shown = Box(made.data_window.x0 + 5, made.data_window.y0, 60, 40)
    assert overscan_px(replace(made, display_window=shown)) == 0
