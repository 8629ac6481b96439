"""Test how much overscan a lens needs, against the disc radius of a formula."""

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


def plate_with_margin(near_m: float, far_m: float, margin: int = 0):
    depth_m = np.full((54, 96), far_m, np.float32)
    depth_m[:, :10] = near_m
    plate = plate_of(COLOR, depth_m)
    data_window = plate.data_window
    box = Box(
        data_window.x0 + margin,
        data_window.y0 + margin,
        data_window.x1 - margin,
        data_window.y1 - margin,
    )
    return replace(plate, display_window=box)


def radius_px(depth_m: float, focus_m: float, width_px: int) -> float:
    """Return the blur radius A f / (S - f) |1 - S / z| on the sensor, in pixels."""
    f_m, opening_m = 0.05, 0.025
    disc_m = opening_m * f_m / (focus_m - f_m) * abs(1 - focus_m / depth_m)
    return disc_m / 0.036 * width_px / 2


@pytest.mark.parametrize(("near_m", "far_m", "widest_m"), [(0.5, 3.0, 0.5), (1.9, 50.0, 50.0)])
def test_overscan_need_is_radius_of_widest_disc(near_m, far_m, widest_m):
    need = overscan_need(plate_with_margin(near_m, far_m), {1001: LENS})
    assert need.needed_px == pytest.approx(radius_px(widest_m, 2.0, 96), rel=1e-6)
    assert (need.at_frame, need.has_px) == (1001, 0)


def test_overscan_need_of_squeezed_disc_is_its_longer_side():
    plain, squeezed = (
        overscan_need(plate_with_margin(0.5, 3.0), {1: replace(LENS, squeeze=squeeze)})
        for squeeze in (1, 2)
    )
    assert squeezed.needed_px == pytest.approx(plain.needed_px)


def test_overscan_need_lists_short_frames_as_ranges():
    f_stops = {frame: 8.0 for frame in range(1, 9)} | {3: 0.7, 4: 0.7, 7: 0.7}
    lenses = {frame: replace(LENS, f_stop=f_stop) for frame, f_stop in f_stops.items()}
    need = overscan_need(plate_with_margin(0.5, 3.0, margin=3), lenses)
    assert need.short == (FrameRange(3, 4), FrameRange(7, 7))
    assert need.sentence == (
        "Borders are guessed: the plate has 3 px of overscan. Render it 5 px wider on every side."
    )
    assert "frames 3-4, 7." in need.sentence.why


def test_overscan_need_of_sufficient_plate_lists_no_frames():
    need = overscan_need(plate_with_margin(0.9, 3.0, margin=8), {1: replace(LENS, f_stop=16.0)})
    assert not need.short


def test_overscan_need_without_depth_or_lenses_is_none():
    assert overscan_need(coc_plate_of(COLOR, np.ones((54, 96), np.float32)), {1: LENS}) is None
    assert overscan_need(plate_with_margin(1.0, 2.0), {}) is None


def test_overscan_px_is_that_of_narrowest_side():
    flat_plate = plate_with_margin(1.0, 2.0)
    display_window = Box(flat_plate.data_window.x0 + 5, flat_plate.data_window.y0, 60, 40)
    assert overscan_px(replace(flat_plate, display_window=display_window)) == 0
