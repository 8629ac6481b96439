"""Test the thin lens: worked values, the textbook formula, and near, far and hyperfocal limits."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from heatlens.core.model.focus.coc import (
    CocLine,
    coc_line,
    coc_px,
    depth_of_field_m,
    far_limit_m,
    hyperfocal_m,
    lens_diameter_m,
    near_limit_m,
)
from heatlens.core.model.lens.lens import Lens, LensModel

FIFTY = Lens(focal_length_mm=50.0, f_stop=2.0, focus_distance_m=2.0, sensor_width_mm=36.0)

LENSES = st.builds(
    Lens,
    focal_length_mm=st.floats(5, 1000),
    f_stop=st.floats(0.7, 45),
    focus_distance_m=st.one_of(st.floats(1.2, 1e5), st.just(math.inf)),
    sensor_width_mm=st.floats(5, 80),
    acceptable_coc_mm=st.floats(1e-3, 0.2),
    model=st.sampled_from(list(LensModel)),
)


def coc_mm(lens: Lens, depth_m: float) -> float:
    """Return the diameter of the disc on the sensor in mm, by a picture of one pixel per mm."""
    one_px_a_mm = replace(lens, sensor_width_mm=1.0, acceptable_coc_mm=lens.coc_limit_mm)
    return float(coc_px(depth_m, coc_line(one_px_a_mm, 1)))


# 50 mm at f/2: A = 25 mm, A f = 1250 mm2. Focused at 2 m: 1250 / 1950 = 0.641026 mm at infinity,
# times 1920 / 36 pixels a millimetre = 34.188034 px; half of it at 4 m, minus the same at 1 m.
@pytest.mark.parametrize(
    ("depth_m", "diameter_px"),
    [(math.inf, 34.188034), (4.0, 17.094017), (2.0, 0.0), (1.0, -34.188034), (0.5, -102.564103)],
)
def test_coc_px_matches_values_worked_by_hand(depth_m, diameter_px):
    assert coc_px(depth_m, coc_line(FIFTY, 1920)) == pytest.approx(diameter_px, abs=1e-6)


# Focused at infinity: -1250 mm2 / 5000 mm = -0.25 mm at 5 m, which is -13.333333 px.
@pytest.mark.parametrize(("depth_m", "diameter_px"), [(math.inf, 0.0), (5.0, -13.333333)])
def test_coc_px_matches_worked_values_with_focus_at_infinity(depth_m, diameter_px):
    line = coc_line(replace(FIFTY, focus_distance_m=math.inf), 1920)
    assert coc_px(depth_m, line) == pytest.approx(diameter_px, abs=1e-6)
    assert line.at_infinity_px == 0.0


@given(LENSES, st.floats(0.01, 1e7), st.integers(1, 16384))
def test_coc_px_agrees_with_textbook_formula(lens, depth_m, width_px):
    assume(math.isfinite(lens.focus_distance_m))
    z, s, f = 1e3 * depth_m, 1e3 * lens.focus_distance_m, lens.focal_length_mm
    image_mm = f if lens.model is LensModel.RENDERER else f * s / (s - f)
    expected = (f / lens.f_stop) * (z - s) / z * image_mm / s * width_px / lens.sensor_width_mm
    line = coc_line(lens, width_px)
    assert coc_px(depth_m, line) == pytest.approx(
        expected, rel=1e-9, abs=1e-12 * line.at_infinity_px
    )


@given(LENSES, st.floats(0.01, 1e7))
def test_renderer_lens_model_has_lens_radius_f_over_2n(lens, depth_m):
    """Compare with the cone of rays from the lens edge through the focus, at another depth."""
    assume(math.isfinite(lens.focus_distance_m))
    lens = replace(lens, model=LensModel.RENDERER)
    radius_m = 1e-3 * lens.focal_length_mm / (2 * lens.f_stop)
    assert lens_diameter_m(lens) == pytest.approx(2 * radius_m, rel=1e-12)
    spread_m = radius_m * (1 - depth_m / lens.focus_distance_m)  # of the cone, around the axis
    focal_px = 1920 * lens.focal_length_mm / lens.sensor_width_mm
    diameter_px = coc_px(depth_m, coc_line(lens, 1920))
    assert diameter_px == pytest.approx(-2 * spread_m / depth_m * focal_px, rel=1e-9, abs=1e-9)


# 50 mm at 1.1 m: 1.1 / 1.05; 85 mm at 0.6 m: 0.6 / 0.515.
@pytest.mark.parametrize(
    ("focal_mm", "focus_m", "ratio"), [(50, 1.1, 22 / 21), (85, 0.6, 120 / 103)]
)
def test_photographic_lens_has_larger_discs_than_renderer_model(focal_mm, focus_m, ratio):
    lens = Lens(focal_mm, 2.0, focus_m, 36.0)
    real = coc_line(lens, 1920)
    renderer = coc_line(replace(lens, model=LensModel.RENDERER), 1920)
    assert real.at_infinity_px / renderer.at_infinity_px == pytest.approx(ratio, rel=1e-12)


@given(LENSES, st.floats(0.01, 1e7))
def test_coc_px_is_negative_in_front_zero_in_focus_positive_behind(lens, depth_m):
    line = coc_line(lens, 1920)
    assert coc_px(lens.focus_distance_m, line) == 0.0
    apart = abs(depth_m - lens.focus_distance_m) > 1e-9 * depth_m
    assume(apart)
    assert np.sign(coc_px(depth_m, line)) == np.sign(depth_m - lens.focus_distance_m)


@given(LENSES)
def test_coc_line_of_very_far_focus_tends_to_focus_at_infinity(lens):
    near = coc_line(replace(lens, focus_distance_m=1e12), 1920)
    far = coc_line(replace(lens, focus_distance_m=math.inf), 1920)
    assert near.per_dioptre_px == pytest.approx(far.per_dioptre_px, rel=1e-9)
    assert near.at_infinity_px == pytest.approx(0.0, abs=1e-9 * abs(far.per_dioptre_px))


def test_coc_px_of_array_keeps_its_shape():
    depth_m = np.array([[1.0, 2.0, np.inf], [4.0, 0.5, 1.0]], np.float32)
    diameters = coc_px(depth_m, CocLine(10.0, -20.0))
    np.testing.assert_array_equal(diameters, [[-10, 0, 10], [5, -30, -10]])


# With c = 0.025 mm: H = 0.05 + 1.25 / 0.025 = 50.05 m. Focused at 2 m,
# near = 2 (H - 0.05) / (H + 2 - 0.1) = 100 / 51.95 and far = 100 / (H - 2) = 100 / 48.05.
def test_focus_limits_match_values_worked_by_hand():
    lens = replace(FIFTY, acceptable_coc_mm=0.025)
    assert hyperfocal_m(lens) == pytest.approx(50.05, rel=1e-12)
    assert near_limit_m(lens) == pytest.approx(1.924928, abs=1e-6)
    assert far_limit_m(lens) == pytest.approx(2.081165, abs=1e-6)
    assert depth_of_field_m(lens) == pytest.approx(0.156237, abs=1e-6)


# Focused at infinity the near limit is A f / c = 50 m: the hyperfocal less the focal length.
def test_focus_limits_match_worked_values_with_focus_at_infinity():
    lens = replace(FIFTY, focus_distance_m=math.inf, acceptable_coc_mm=0.025)
    assert near_limit_m(lens) == pytest.approx(50.0, rel=1e-12)
    assert far_limit_m(lens) == depth_of_field_m(lens) == math.inf


@given(LENSES)
def test_disc_at_near_and_far_limit_is_the_acceptable_one(lens):
    limit_mm = lens.coc_limit_mm
    rounding = 1e-12 * (1 + coc_mm(lens, math.inf))
    assert coc_mm(lens, near_limit_m(lens)) == pytest.approx(-limit_mm, abs=rounding)
    if math.isfinite(far_limit_m(lens)):
        assert coc_mm(lens, far_limit_m(lens)) == pytest.approx(limit_mm, abs=rounding)
    else:
        assert coc_mm(lens, math.inf) <= limit_mm


@given(LENSES)
def test_focus_distance_lies_between_near_and_far_limit(lens):
    assert near_limit_m(lens) < lens.focus_distance_m <= far_limit_m(lens)


@given(LENSES, st.floats(1e-6, 1e-2))
def test_far_limit_is_infinite_exactly_beyond_hyperfocal_distance(lens, margin):
    at_m = hyperfocal_m(lens)
    assume(at_m * 1e3 > lens.focal_length_mm)
    farther_lens = replace(lens, focus_distance_m=at_m * (1 + margin))
    assert far_limit_m(farther_lens) == math.inf
    assume(at_m / (1 + margin) * 1e3 > lens.focal_length_mm)
    assert math.isfinite(far_limit_m(replace(lens, focus_distance_m=at_m / (1 + margin))))


@given(LENSES)
def test_t_stop_and_squeeze_do_not_change_coc_line(lens):
    changed_lens = replace(lens, t_stop=22.0, squeeze=2.0)
    assert coc_line(changed_lens, 1920) == coc_line(lens, 1920)
    assert hyperfocal_m(changed_lens) == hyperfocal_m(lens)
