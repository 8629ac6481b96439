"""Openings that are no ellipses: area, brightness and barrel, against grids and closed forms."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatlens.core.base.errors import LensError
from heatlens.core.model.lens import opening
from heatlens.core.model.lens.aperture import Aperture
from heatlens.core.model.lens.disc_shape import DiscShape, PictureField
from heatlens.core.model.lens.opening import Barrel, Blades
from support.apertures import apertures

GRID = (np.indices((200, 200)) + 0.5) / 100 - 1
curvatures = st.floats(0.0, 1.0)
counts = st.integers(3, 16)


@pytest.mark.parametrize(
    "values",
    [
        {"blades": 1},
        {"blades": 2},
        {"blades": 17},
        {"blades": -3},
        {"blade_curvature": 1.01},
        {"blade_curvature": math.nan},
        {"blade_rotation_deg": math.inf},
        {"cat_eye": -0.1},
        {"rim": 1.2},
        {"axial_colour_mm": 6.0},
    ],
)
def test_aperture_rejects_impossible_field_and_names_it(values: dict[str, float]) -> None:
    (name,) = values
    words = name.replace("_deg", "").replace("_mm", "").replace("_", " ")
    with pytest.raises(LensError, match=rf"^The (number of )?{words} must be"):
        Aperture(**values)  # type: ignore[arg-type]


@given(counts)
def test_straight_blades_have_area_and_variance_of_regular_polygon(count: int) -> None:
    """The area is n/2 sin(2 pi / n); the variance follows from the polygon's second moment."""
    blades, turn = Blades(number=count, turn=0.3, curvature=0.0), 2 * math.pi / count
    assert opening.light(blades, None, 0.0) == pytest.approx(count / 2 * math.sin(turn), rel=1e-4)
    variance = (2 + math.cos(turn)) / 12
    assert opening.variance(blades, 0.0) == pytest.approx(variance, rel=1e-3)


@given(counts, st.floats(-1, 1))
def test_fully_curved_blades_form_a_circle(count: int, rim: float) -> None:
    blades = Blades(number=count, turn=0.3, curvature=1.0)
    assert opening.light(blades, None, rim) == pytest.approx(math.pi, rel=1e-6)
    angle = np.linspace(0, 6, 50)
    np.testing.assert_allclose(opening.rim_radius(angle, blades, None), 1.0, rtol=1e-9)


@given(counts, st.floats(-6, 6), curvatures)
def test_rim_radius_is_1_at_corners_and_zero_of_past_blades(
    count: int, turn: float, curvature: float
) -> None:
    blades = Blades(count, turn, curvature)
    corners = turn + 2 * math.pi * np.arange(count) / count
    np.testing.assert_allclose(opening.rim_radius(corners, blades, None), 1.0, atol=1e-6)
    angle = np.linspace(0, 6.2, 40) + 0.01
    reach = opening.rim_radius(angle, blades, None)
    x, y = reach * np.cos(angle), reach * np.sin(angle)
    np.testing.assert_allclose(opening.past_blades(x, y, blades)[0], 0.0, atol=1e-9)


@given(st.floats(-1, 1))
def test_opening_profile_has_mean_1_for_any_rim(rim: float) -> None:
    square = GRID[0] ** 2 + GRID[1] ** 2
    brightness = opening.profile(square[square <= 1], rim)
    assert brightness.min() > 0.0
    assert brightness.mean() == pytest.approx(1.0, abs=0.01)


def test_bright_rim_behind_focus_is_dark_rim_in_front() -> None:
    disc = DiscShape(Aperture(rim=1.0))
    middle, near_rim = (
        [float(disc.coverage(x, 0.0, r, 0.5)) for r in (50.0, -50.0)] for x in (0.0, 47.0)
    )
    assert middle[0] < 0.1 < 2.5 < middle[1]
    assert near_rim[1] < 0.1 < 2.0 < near_rim[0]


@settings(max_examples=30)
@given(apertures(), st.sampled_from((-30.0, 30.0)), st.floats(0, 200), st.floats(0, 100))
def test_light_of_shaped_disc_equals_sum_of_its_coverage(
    aperture: Aperture, radius_px: float, x_px: float, y_px: float
) -> None:
    disc = DiscShape(aperture, pixel_aspect_ratio=1.0, in_picture=PictureField.of((200, 100)))
    y, x = np.mgrid[-33:34, -33:34]
    total = float(disc.coverage(x, y, radius_px, 0.5, (x_px, y_px)).sum())
    assert total == pytest.approx(disc.light(radius_px, 0.5, (x_px, y_px)), rel=0.03, abs=30)


@settings(max_examples=30)
@given(apertures(), st.floats(2.0, 40.0))
def test_disc_in_front_of_focus_is_rotated_by_180_degrees(
    aperture: Aperture, radius_px: float
) -> None:
    """This holds at the middle of the picture; the sign of `rim` is reversed as well."""
    y, x = np.mgrid[-40:41, -40:41]
    front = DiscShape(aperture).coverage(x, y, -radius_px, 0.5)
    turned = {"rim": -aperture.rim}
    mirrored = DiscShape(_replace_fields(aperture, turned)).coverage(-x, -y, radius_px, 0.5)
    np.testing.assert_allclose(front, mirrored, atol=1e-6)


def _replace_fields(aperture: Aperture, values: dict[str, float]) -> Aperture:
    fields = {name: getattr(aperture, name) for name in Aperture.__dataclass_fields__}
    return Aperture(**(fields | values))


def test_light_past_barrel_equals_area_of_two_circle_overlap() -> None:
    """Their area is known: 2 acos(d / 2) - d / 2 sqrt(4 - d^2)."""
    for shift in (0.1, 0.5, 0.9):
        barrel = Barrel((0.6 * shift / 2, 0.8 * shift / 2), 1.0)
        area = 2 * math.acos(shift / 2) - shift / 2 * math.sqrt(4 - shift**2)
        assert opening.light(Blades(0, 0.0, 0.0), barrel, 0.0) == pytest.approx(area, rel=1e-3)


def test_barrel_cuts_more_at_corner_and_less_when_stopped_down() -> None:
    field = PictureField.of((200, 100))

    def light(position_px: tuple[float, float], stopped_down: float) -> float:
        aperture = Aperture(cat_eye=0.8, stopped_down=stopped_down)
        return DiscShape(aperture, 1.0, field).light(1e-3, 1e-9, position_px) / 1e-6

    middle, side, corner = (
        light(position_px, 1.0) for position_px in ((100, 50), (200, 50), (200, 100))
    )
    assert middle == pytest.approx(math.pi, rel=1e-3) and middle > side > corner
    stops = [light((200, 100), n) for n in (1.0, 1.4, 2.0, 2.8, 5.7)]
    assert stops == sorted(stops) and stops[-1] == pytest.approx(math.pi, rel=1e-3)


def test_cat_eye_cuts_disc_left_and_right_at_right_side_of_picture() -> None:
    disc = DiscShape(Aperture(cat_eye=0.8), 1.0, PictureField.of((200, 100)))
    right = (190.0, 50.0)
    for radius_px in (20.0, -20.0):
        across = disc.coverage(np.array([-18, 18]), 0, radius_px, 0.5, right)
        down = disc.coverage(0, np.array([-17, 17]), radius_px, 0.5, right)
        assert not across.any() and np.all(down == 1.0)


def test_blade_corner_points_up_and_rotates_counterclockwise() -> None:
    def reach_px(aperture: Aperture, x: float, y: float) -> float:
        coverage = DiscShape(aperture).coverage(x * np.arange(100), y * np.arange(100), 90.0, 0.5)
        return float(coverage.sum())

    up, down = reach_px(Aperture(blades=3), 0, -1), reach_px(Aperture(blades=3), 0, 1)
    assert up == pytest.approx(90, abs=1) and down == pytest.approx(45, abs=1)
    turned = Aperture(blades=3, blade_rotation_deg=90.0)
    assert reach_px(turned, -1, 0) == pytest.approx(90, abs=1)


def test_variances_past_barrel_match_points_of_two_circle_overlap() -> None:
    """Compare with the variance of even points inside both circles."""
    np.testing.assert_allclose(opening.variances(Barrel((0.0, 0.0), 1.0)), 0.25, rtol=1e-6)
    for shift in (0.2, 0.5):
        y, x = GRID
        lit = (np.abs(x) + shift) ** 2 + y**2 <= 1
        expected = np.var(x[lit]), np.var(y[lit])
        variances = opening.variances(Barrel((shift, 0.0), 1.0))
        np.testing.assert_allclose(variances, expected, rtol=0.02)
