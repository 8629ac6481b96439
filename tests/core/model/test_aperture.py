"""The opening of the lens: its extent, area and points, against closed forms."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import LensError
from heatlens.core.model.lens.aperture import Aperture
from heatlens.core.model.lens.disc_shape import DiscShape
from heatlens.core.model.lens.pupil import PINHOLE, Pupil

squeezes = st.floats(1.0, 2.0)
aspects = st.floats(0.25, 4.0)
unit = st.floats(0.0, 1.0, exclude_max=True)


def even_grid(side: int) -> np.ndarray:
    """Return the centers (side^2, 2) of the cells of a grid over the unit square."""
    centers = (np.arange(side) + 0.5) / side
    return np.stack(np.meshgrid(centers, centers), axis=-1).reshape(-1, 2)


@pytest.mark.parametrize("squeeze", [0.0, 0.99, 2.01, -1.0, math.nan, math.inf])
def test_aperture_rejects_squeeze_outside_1_to_2(squeeze: float) -> None:
    with pytest.raises(LensError, match="squeeze must be between 1 and 2"):
        Aperture(squeeze=squeeze)


@given(squeezes)
def test_aperture_area_equals_area_of_covered_points(squeeze: float) -> None:
    aperture = Aperture(squeeze=squeeze)
    u, v = (2 * even_grid(256) - 1).T
    share = np.mean(aperture.covers(u, v))
    assert 4 * share == pytest.approx(aperture.area, rel=2e-3)
    assert aperture.area == pytest.approx(math.pi / squeeze, rel=1e-12)


@given(squeezes)
def test_half_extents_bound_the_covered_points(squeeze: float) -> None:
    aperture = Aperture(squeeze=squeeze)
    u, v = (2 * even_grid(512) - 1).T
    inside = aperture.covers(u, v)
    measured_extents = np.abs(u[inside]).max(), np.abs(v[inside]).max()
    np.testing.assert_allclose(measured_extents, aperture.half_extents, atol=2 / 512)


@given(squeezes, st.floats(1e-4, 1.0), unit, unit)
def test_aperture_points_are_covered_by_aperture(
    squeeze: float, radius: float, x: float, y: float
) -> None:
    aperture = Aperture(squeeze=squeeze)
    ((u, v),) = aperture.points(np.array([[x, y]]), radius) / radius
    assert aperture.covers(0.999999 * u, 0.999999 * v)


@given(squeezes, st.floats(0.01, 0.98), st.floats(0.01, 0.98))
def test_aperture_points_map_equal_areas_to_equal_areas(squeeze: float, x: float, y: float) -> None:
    """The Jacobian determinant of the map is constant and equals the area of the aperture."""
    step, aperture = 1e-6, Aperture(squeeze=squeeze)
    corners = np.array([[x, y], [x + step, y], [x, y + step]])
    centered = 2 * corners - 1  # the map has a kink on the two diagonals
    if np.any(np.abs(np.abs(centered[:, 0]) - np.abs(centered[:, 1])) < 1e-3):
        return
    here, across, up = aperture.points(corners)
    determinant = np.linalg.det(np.stack([across - here, up - here])) / step**2
    assert abs(determinant) == pytest.approx(aperture.area, rel=1e-3)


@given(squeezes)
def test_aperture_points_of_even_grid_fill_aperture_evenly(squeeze: float) -> None:
    aperture = Aperture(squeeze=squeeze)
    u, v = aperture.points(even_grid(128)).T / np.array(aperture.half_extents)[:, None]
    assert abs(np.mean(u)) < 1e-3 and abs(np.mean(v)) < 1e-3
    np.testing.assert_allclose(np.cov(u, v, bias=True), np.eye(2) / 4, atol=1e-3)
    for radius in (0.25, 0.5, 0.75):
        assert np.mean(np.hypot(u, v) < radius) == pytest.approx(radius**2, abs=0.01)


@given(squeezes, st.floats(1e-3, 1.0))
def test_pupil_points_are_aperture_points_times_radius(squeeze: float, radius_m: float) -> None:
    pupil, square = Pupil(Aperture(squeeze=squeeze), radius_m), even_grid(8)
    np.testing.assert_allclose(pupil.half_extents_m, (radius_m / squeeze, radius_m), rtol=1e-12)
    np.testing.assert_allclose(
        pupil.points_m(square), radius_m * pupil.aperture.points(square), rtol=1e-12, atol=1e-15
    )


def test_pinhole_has_zero_extent_and_all_points_at_origin() -> None:
    assert not PINHOLE.points_m(even_grid(4)).any()
    assert PINHOLE.half_extents_m == (0.0, 0.0)


@pytest.mark.parametrize(
    ("squeeze", "aspect", "extents"),
    [
        (1.0, 1.0, (1.0, 1.0)),
        (2.0, 1.0, (0.5, 1.0)),
        (1.0, 2.0, (1.0, 2.0)),
        (1.25, 0.5, (0.8, 0.5)),
    ],
)
def test_disc_half_extents_follow_squeeze_and_pixel_aspect(
    squeeze: float, aspect: float, extents: tuple[float, float]
) -> None:
    assert DiscShape(Aperture(squeeze=squeeze), aspect).half_extents == extents


@given(squeezes, aspects, st.floats(20.0, 60.0), st.floats(0.5, 2.0))
def test_disc_light_equals_sum_of_pixel_coverage(
    squeeze: float, aspect: float, radius_px: float, ramp_px: float
) -> None:
    disc = DiscShape(Aperture(squeeze=squeeze), aspect)
    across, down = (math.ceil(radius_px * half + ramp_px) for half in disc.half_extents)
    y, x = np.mgrid[-down : down + 1, -across : across + 1]
    total = float(disc.coverage(x, y, radius_px, ramp_px).sum())
    assert total == pytest.approx(disc.light(radius_px, ramp_px), rel=0.03)


@given(squeezes, aspects, st.floats(2.0, 40.0))
def test_disc_coverage_is_1_inside_and_0_outside_of_aperture(
    squeeze: float, aspect: float, radius_px: float
) -> None:
    """By definition a pixel is lit if the aperture covers the pixel's point of the lens."""
    disc = DiscShape(Aperture(squeeze=squeeze), aspect)
    across, down = (math.ceil(radius_px * half) + 2 for half in disc.half_extents)
    y, x = np.mgrid[-down : down + 1, -across : across + 1]
    ramp_px = 0.01
    for radius in (radius_px, -radius_px):
        covered = disc.aperture.covers(x / radius, -y / (radius * aspect))
        coverage = disc.coverage(x, y, radius, ramp_px)
        on_edge = (coverage > 0) & (coverage < 1)
        assert np.count_nonzero(on_edge) <= 0.2 * on_edge.size
        np.testing.assert_array_equal(coverage[~on_edge], covered[~on_edge])


@given(aspects, st.floats(2.0, 40.0), st.floats(0.2, 3.0))
def test_coverage_at_edge_of_round_disc_is_linear_ramp(
    aspect: float, radius_px: float, ramp_px: float
) -> None:
    """Along x the distance to the edge is known, and a pixel on the edge is half covered."""
    x = np.linspace(0.5, 2 * radius_px, 64)
    expected = np.clip((radius_px - x + ramp_px) / (2 * ramp_px), 0, 1)
    coverage = DiscShape(Aperture(), aspect).coverage(x, 0.0, radius_px, ramp_px)
    np.testing.assert_allclose(coverage, expected, atol=1e-9)
