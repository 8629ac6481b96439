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
    """Return the (side^2, 2) middles of the cells of the unit square."""
    at = (np.arange(side) + 0.5) / side
    return np.stack(np.meshgrid(at, at), axis=-1).reshape(-1, 2)


@pytest.mark.parametrize("squeeze", [0.0, 0.99, 2.01, -1.0, math.nan, math.inf])
def test_an_impossible_squeeze_is_refused(squeeze: float) -> None:
    with pytest.raises(LensError, match="squeeze must be between 1 and 2"):
        Aperture(squeeze=squeeze)


@given(squeezes)
def test_the_area_is_that_of_the_points_that_it_covers(squeeze: float) -> None:
    aperture = Aperture(squeeze=squeeze)
    u, v = (2 * even_grid(256) - 1).T
    share = np.mean(aperture.covers(u, v))
    assert 4 * share == pytest.approx(aperture.area, rel=2e-3)
    assert aperture.area == pytest.approx(math.pi / squeeze, rel=1e-12)


@given(squeezes)
def test_the_extents_are_those_of_the_points_that_it_covers(squeeze: float) -> None:
    aperture = Aperture(squeeze=squeeze)
    u, v = (2 * even_grid(512) - 1).T
    inside = aperture.covers(u, v)
    found = np.abs(u[inside]).max(), np.abs(v[inside]).max()
    np.testing.assert_allclose(found, aperture.half_extents, atol=2 / 512)


@given(squeezes, st.floats(1e-4, 1.0), unit, unit)
def test_points_lie_in_the_opening(squeeze: float, radius: float, x: float, y: float) -> None:
    aperture = Aperture(squeeze=squeeze)
    ((u, v),) = aperture.points(np.array([[x, y]]), radius) / radius
    assert aperture.covers(0.999999 * u, 0.999999 * v)


@given(squeezes, st.floats(0.01, 0.98), st.floats(0.01, 0.98))
def test_points_keep_areas(squeeze: float, x: float, y: float) -> None:
    """The determinant of the derivative is the same everywhere: the area of the opening."""
    step, aperture = 1e-6, Aperture(squeeze=squeeze)
    corners = np.array([[x, y], [x + step, y], [x, y + step]])
    at = 2 * corners - 1  # the map has a kink on the two diagonals
    if np.any(np.abs(np.abs(at[:, 0]) - np.abs(at[:, 1])) < 1e-3):
        return
    here, across, up = aperture.points(corners)
    determinant = np.linalg.det(np.stack([across - here, up - here])) / step**2
    assert abs(determinant) == pytest.approx(aperture.area, rel=1e-3)


@given(squeezes)
def test_even_points_are_even_in_the_opening(squeeze: float) -> None:
    aperture = Aperture(squeeze=squeeze)
    u, v = aperture.points(even_grid(128)).T / np.array(aperture.half_extents)[:, None]
    assert abs(np.mean(u)) < 1e-3 and abs(np.mean(v)) < 1e-3
    np.testing.assert_allclose(np.cov(u, v, bias=True), np.eye(2) / 4, atol=1e-3)
    for radius in (0.25, 0.5, 0.75):
        assert np.mean(np.hypot(u, v) < radius) == pytest.approx(radius**2, abs=0.01)


@given(squeezes, st.floats(1e-3, 1.0))
def test_a_pupil_is_its_aperture_in_metres(squeeze: float, radius_m: float) -> None:
    pupil, square = Pupil(Aperture(squeeze=squeeze), radius_m), even_grid(8)
    np.testing.assert_allclose(pupil.half_extents_m, (radius_m / squeeze, radius_m), rtol=1e-12)
    np.testing.assert_allclose(
        pupil.points_m(square), radius_m * pupil.aperture.points(square), rtol=1e-12, atol=1e-15
    )


def test_a_pinhole_is_one_point() -> None:
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
def test_squeeze_narrows_a_disc_and_wide_pixels_lower_it(
    squeeze: float, aspect: float, extents: tuple[float, float]
) -> None:
    assert DiscShape(Aperture(squeeze=squeeze), aspect).half_extents == extents


@given(squeezes, aspects, st.floats(20.0, 60.0), st.floats(0.5, 2.0))
def test_the_light_of_a_disc_is_the_sum_of_its_pixels(
    squeeze: float, aspect: float, radius_px: float, ramp_px: float
) -> None:
    disc = DiscShape(Aperture(squeeze=squeeze), aspect)
    across, down = (math.ceil(radius_px * half + ramp_px) for half in disc.half_extents)
    y, x = np.mgrid[-down : down + 1, -across : across + 1]
    total = float(disc.coverage(x, y, radius_px, ramp_px).sum())
    assert total == pytest.approx(disc.light(radius_px, ramp_px), rel=0.03)


@given(squeezes, aspects, st.floats(2.0, 40.0))
def test_pixels_well_inside_are_whole_and_those_well_outside_empty(
    squeeze: float, aspect: float, radius_px: float
) -> None:
    """Against the definition: a pixel whose point of the lens the aperture covers is lit."""
    disc = DiscShape(Aperture(squeeze=squeeze), aspect)
    across, down = (math.ceil(radius_px * half) + 2 for half in disc.half_extents)
    y, x = np.mgrid[-down : down + 1, -across : across + 1]
    ramp_px = 0.01
    for radius in (radius_px, -radius_px):
        covered = disc.aperture.covers(x / radius, -y / (radius * aspect))
        shown = disc.coverage(x, y, radius, ramp_px)
        on_rim = (shown > 0) & (shown < 1)
        assert np.count_nonzero(on_rim) <= 0.2 * on_rim.size
        np.testing.assert_array_equal(shown[~on_rim], covered[~on_rim])


@given(aspects, st.floats(2.0, 40.0), st.floats(0.2, 3.0))
def test_the_rim_of_a_round_disc_is_a_straight_ramp(
    aspect: float, radius_px: float, ramp_px: float
) -> None:
    """Along x the distance to the rim is known, and half of a pixel on the rim is covered."""
    x = np.linspace(0.5, 2 * radius_px, 64)
    expected = np.clip((radius_px - x + ramp_px) / (2 * ramp_px), 0, 1)
    shown = DiscShape(Aperture(), aspect).coverage(x, 0.0, radius_px, ramp_px)
    np.testing.assert_allclose(shown, expected, atol=1e-9)
