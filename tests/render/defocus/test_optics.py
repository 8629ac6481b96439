"""Optics: the circle of confusion of a lens and plate, its range, proxy scale and color shifts."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.focus.coc import CocLine
from heatlens.core.model.lens.aperture import Aperture
from heatlens.core.model.lens.disc_shape import DiscShape
from heatlens.core.model.lens.lens import Lens, LensModel
from heatlens.core.model.value_bins import BINS, ValueBins, bin_values
from heatlens.render.defocus.optics import Color, Optics
from heatlens.render.source.pinhole import optics_of
from support.plates import coc_plate_of, plate_of

SQUEEZED = DiscShape(Aperture(squeeze=2.0), 1.5)
WINDOW = (1, 40)  # pixels of the plates here, height and width
LENSES = st.builds(
    Lens,
    focal_length_mm=st.floats(12, 200),
    f_stop=st.floats(0.7, 22),
    focus_distance_m=st.floats(0.5, 100) | st.just(math.inf),
    sensor_width_mm=st.floats(10, 60),
    model=st.sampled_from(LensModel),
)
COCS = st.lists(st.floats(-300, 300), min_size=1, max_size=9).map(lambda v: np.sort(np.array(v)))
LINES = st.builds(CocLine, st.floats(0, 300), st.floats(-300, -1))
SCALES = st.floats(0.05, 1.0)


def optics_at(lens: Lens, *depths_m: float) -> Optics:
    """Return the optics for a plate whose dioptres are between those of `depths_m`."""
    shape = np.ones(WINDOW, np.float32)
    plate = plate_of(np.ones((*WINDOW, 3), np.float32), shape)
    dioptres = 1.0 / np.array(depths_m)
    bins = ValueBins(low=dioptres.min(), high=dioptres.max(), counts=np.ones(BINS, np.int64))
    return optics_of(plate, bins, lens)


def sensor_mm(lens: Lens, depth_m: float) -> float:
    """Return the signed disc on the sensor, traced through the lens in millimetres.

    The cone of light from the lens, as wide as its opening, meets in its image and is cut by the
    sensor, which lies where the focus has its image. A renderer's cone is that of a pinhole's.
    """
    f, opening = lens.focal_length_mm, lens.focal_length_mm / lens.f_stop
    focus, point = 1e3 * lens.focus_distance_m, 1e3 * depth_m
    if lens.model is LensModel.RENDERER:
        return opening * f * (1 / focus - 1 / point)
    sensor, image = 1 / (1 / f - 1 / focus), 1 / (1 / f - 1 / point)
    return opening * (sensor - image) / image


@given(LENSES, st.floats(0.5, 1000) | st.just(math.inf))
def test_coc_equals_diameter_of_traced_cone(lens: Lens, depth_m: float) -> None:
    traced = sensor_mm(lens, depth_m) * WINDOW[1] / lens.sensor_width_mm
    optics = optics_at(lens, depth_m)
    assert optics.nearest_px == pytest.approx(traced, rel=1e-6, abs=1e-9)
    assert optics.farthest_px == optics.nearest_px


@given(LENSES)
def test_coc_is_negative_before_focus_and_positive_behind(lens: Lens) -> None:
    focus_m = min(lens.focus_distance_m, 1e3)
    optics = optics_at(lens, focus_m * 0.8, focus_m * 1.25)
    assert optics.nearest_px < 0
    assert (optics.farthest_px > 0) == math.isfinite(lens.focus_distance_m)
    assert optics.nearest_px < optics.farthest_px


@given(LENSES)
def test_coc_at_infinity_equals_coc_of_sky(lens: Lens) -> None:
    optics = optics_at(lens, 1.0, math.inf)
    assert optics.at_infinity_px == pytest.approx(optics.farthest_px)
    assert (optics.at_infinity_px == 0) == math.isinf(lens.focus_distance_m)


def test_coc_at_infinity_of_coc_plate_is_its_largest() -> None:
    plate = coc_plate_of(np.ones((*WINDOW, 3), np.float32), np.zeros(WINDOW))
    optics = optics_of(
        plate, bin_values(np.array([-5.0, 7.0], np.float32)), Lens(50.0, 2.0, 3.0, 36.0)
    )
    assert optics.line is None and optics.at_infinity_px == 7.0


@given(LINES, COCS, SCALES)
def test_scaled_optics_scales_coc_line_and_axial_color(
    line: CocLine, cocs: np.ndarray, proxy: float
) -> None:
    full_size = Optics(line, occupied_px=cocs, disc=replace(SQUEEZED, axial_px=3.0))
    proxy_size = full_size.scaled(proxy)
    assert proxy_size.line == CocLine(line.at_infinity_px * proxy, line.per_dioptre_px * proxy)
    np.testing.assert_allclose(proxy_size.occupied_px, cocs * proxy)
    assert proxy_size.disc.axial_px == pytest.approx(3.0 * proxy)
    assert proxy_size.disc.half_extents == full_size.disc.half_extents


@given(LINES, COCS, st.floats(-20, 20), st.sampled_from(Color), st.booleans())
def test_in_color_shifts_red_and_blue_but_not_green(
    line: CocLine, cocs: np.ndarray, axial_px: float, color: Color, has_line: bool
) -> None:
    optics = Optics(line if has_line else None, cocs, DiscShape(axial_px=axial_px))
    color_optics = optics.in_color(color)
    shift = {Color.RED: -axial_px, Color.GREEN: 0.0, Color.BLUE: axial_px}[color]
    np.testing.assert_allclose(color_optics.occupied_px, cocs + shift)
    assert color_optics.plate_shift_px == (0.0 if has_line else shift)
    assert color_optics.line == (
        CocLine(line.at_infinity_px + shift, line.per_dioptre_px) if has_line else None
    )
    assert color_optics.disc.axial_px == 0.0 and color_optics.disc.aperture.axial_colour_mm == 0.0


def test_scaled_optics_keeps_disc_shape() -> None:
    optics = Optics(CocLine(12.0, -30.0), np.array([-20.0, 12.0]), SQUEEZED).scaled(0.25)
    assert optics.line == CocLine(3.0, -7.5)
    assert (optics.nearest_px, optics.farthest_px, optics.at_infinity_px) == (-5.0, 3.0, 3.0)
    assert optics.disc == SQUEEZED
