"""Blur amount of gather, scatter and pyramid: a disc of diameter d has the variance d^2 / 16."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.shot.settings import Method
from support.discs import analytic_disc, radius_at_half_height, size_for
from support.methods_of_plates import (
    DISCS,
    OTHERS,
    PIXEL_VARIANCE,
    point_blurred,
    render_with_method,
)
from support.plates import FAR_M, coc_plate_of, lens_blurring, moments, plate_of


@pytest.mark.parametrize("method", OTHERS)
@pytest.mark.parametrize("coc_px", [3.0, -6.0, 13.0, 16.1, 40.0])
def test_blurred_point_has_light_and_variance_of_disc(ctx, renderer, method, coc_px):
    side = 2 * int(3 * abs(coc_px)) + 33
    light, *variances = moments(point_blurred(renderer, method, coc_px, side))
    assert light == pytest.approx(1.0, rel=1e-3)
    pixel = 0.0 if method is Method.PYRAMID else 1.2 * PIXEL_VARIANCE
    np.testing.assert_allclose(variances, coc_px**2 / 16, rtol=0.005, atol=pixel)


@pytest.mark.parametrize("method", DISCS)
@pytest.mark.parametrize("diameter", [4.0, 5.0, 8.0, 16.0, 30.0, 75.0])
def test_blurred_point_is_analytic_disc(ctx, renderer, method, diameter):
    disc = analytic_disc(diameter)
    blurred = point_blurred(renderer, method, diameter, size_for(diameter))[..., 0]
    expected = radius_at_half_height(disc, diameter)
    found = radius_at_half_height(blurred.astype(np.float64), diameter)
    assert found == pytest.approx(expected, rel=0.03)
    assert np.linalg.norm(blurred - disc) < 0.1 * np.linalg.norm(disc)


@pytest.mark.parametrize("method", OTHERS)
@pytest.mark.parametrize(("squeeze", "aspect"), [(2.0, 1.0), (1.0, 2.0), (1.0, 0.5), (2.0, 2.0)])
def test_squeeze_narrows_disc_and_pixel_aspect_changes_its_height(
    ctx, renderer, method, squeeze, aspect
):
    color = np.zeros((129, 129, 3), np.float32)
    color[64, 64] = 1.0
    plate = replace(
        plate_of(color, np.full((129, 129), FAR_M, np.float32)), pixel_aspect_ratio=aspect
    )
    blurred = render_with_method(renderer, plate, method, lens_blurring(14.0, 129, squeeze))
    light, x, y = moments(blurred)
    assert light == pytest.approx(1.0, rel=2e-3)
    slack = 2 * PIXEL_VARIANCE * max(1.0, squeeze * aspect, 1 / (squeeze * aspect))
    assert x == pytest.approx((14.0 / squeeze) ** 2 / 16, rel=0.02, abs=slack)
    assert y == pytest.approx((14.0 * aspect) ** 2 / 16, rel=0.02, abs=slack)


@pytest.mark.parametrize("method", OTHERS)
def test_blur_keeps_light_of_square_inside_picture(ctx, renderer, rng, method):
    color = np.zeros((96, 96, 3), np.float32)
    color[32:64, 32:64] = rng.random((32, 32, 3))
    plate = coc_plate_of(color, np.full((96, 96), -11.0, np.float32))
    light = render_with_method(renderer, plate, method)[..., :3].sum((0, 1), np.float64)
    np.testing.assert_allclose(light / color.sum((0, 1), np.float64), 1.0, atol=1e-3)
