"""A lamp out of focus at every preview level: the same light, disc and brightness."""

import numpy as np
import pytest

from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.render.preview.level_choice import cheaper_levels, first_picture_settings
from support.plates import FAR_M, NEAR_M, lens_blurring, plate_of

WIDTH, HEIGHT = 384, 240  # divisible by the scale of every level
AROUND = 0.02
BLUR_PX = 40.0
LIGHT = 300.0


@pytest.fixture(scope="module", params=[FAR_M, NEAR_M], ids=["behind", "in front"])
def lamp(request, renderer):
    color = np.full((HEIGHT, WIDTH, 3), AROUND, np.float32)
    color[HEIGHT // 2, WIDTH // 2] += LIGHT
    renderer.load(plate_of(color, np.full((HEIGHT, WIDTH), request.param, np.float32)))
    return renderer


def enlarge(picture: np.ndarray) -> np.ndarray:
    """Enlarge a smaller picture to (HEIGHT, WIDTH), bilinear as in the window."""
    for axis, side in enumerate((HEIGHT, WIDTH)):
        count = picture.shape[axis]
        positions = (np.arange(side) + 0.5) * count / side
        centres = np.arange(count) + 0.5
        picture = np.apply_along_axis(
            lambda line, positions=positions, x=centres: np.interp(positions, x, line),
            axis,
            picture,
        )
    return picture


@pytest.mark.parametrize(
    "level", cheaper_levels(DefocusSettings()), ids=lambda it: f"{it.quality} {it.proxy:.3f}"
)
def test_lamp_has_same_disc_at_every_preview_level(ctx, lamp, level):
    """Check light, brightness and radius of the disc; only the edge's width varies by level."""
    picture = lamp.pixels(Shot(lens_blurring(BLUR_PX, WIDTH), level))[..., 1]
    pixel = WIDTH / picture.shape[1]
    light = enlarge(picture) - AROUND
    assert light.sum() == pytest.approx(LIGHT, rel=0.01)
    y, x = np.indices(light.shape) + 0.5
    away = np.hypot(x - (WIDTH + 1) / 2, y - (HEIGHT + 1) / 2)
    plateau = float(np.median(light[away < 0.3 * BLUR_PX]))
    assert plateau == pytest.approx(LIGHT / (np.pi * BLUR_PX**2 / 4), rel=0.025)
    half_radius, outer_radius, inner_radius = (
        np.sqrt((light > part * plateau).sum() / np.pi) for part in (0.5, 0.1, 0.9)
    )
    assert half_radius == pytest.approx(BLUR_PX / 2, abs=max(0.35, 0.09 * pixel))
    assert outer_radius - inner_radius <= 0.5 + 1.5 * pixel


def test_lamp_is_a_disc_in_the_first_picture_too(ctx, lamp):
    """Check the share of light within the disc, and that its corners are as dark as its sides."""
    first = first_picture_settings(DefocusSettings(), (WIDTH, HEIGHT), BLUR_PX)
    picture = lamp.pixels(Shot(lens_blurring(BLUR_PX, WIDTH), first))[..., 1]
    pixel = WIDTH / picture.shape[1]
    light = enlarge(picture) - AROUND
    y, x = np.indices(light.shape) + 0.5
    across, down = abs(x - (WIDTH + 1) / 2), abs(y - (HEIGHT + 1) / 2)
    away = np.hypot(across, down)
    assert light[away < BLUR_PX / 2 + 1.5 * pixel].sum() == pytest.approx(LIGHT, rel=0.02)
    ring = abs(away - BLUR_PX / 2) < pixel
    is_diagonal = np.minimum(across, down) > 0.6 * np.maximum(across, down)
    is_beside = np.minimum(across, down) < 0.3 * np.maximum(across, down)
    corners, sides = light[ring & is_diagonal].mean(), light[ring & is_beside].mean()
    assert corners == pytest.approx(sides, rel=0.1)


@pytest.mark.parametrize("blur_px", [14.0, 40.0])
@pytest.mark.parametrize("proxy", [1 / 2, 1 / 4, 1 / 8])
def test_lamp_keeps_its_position_in_proxy(ctx, renderer, proxy, blur_px):
    """Check any position of the lamp in a proxy pixel, whose middle may be 5 pixels away."""
    for offset in (0, 3, 5):
        color = np.full((HEIGHT, WIDTH, 3), AROUND, np.float32)
        color[HEIGHT // 2 + offset, WIDTH // 2 + 7 - offset] += LIGHT
        renderer.load(plate_of(color, np.full((HEIGHT, WIDTH), FAR_M, np.float32)))
        shot = Shot(lens_blurring(blur_px, WIDTH), DefocusSettings(proxy=proxy))
        light = enlarge(renderer.pixels(shot)[..., 1]) - AROUND
        y, x = np.indices(light.shape)
        centroid = [(light * at).sum() / light.sum() for at in (y, x)]
        lamp_position = [HEIGHT // 2 + offset, WIDTH // 2 + 7 - offset]
        np.testing.assert_allclose(centroid, lamp_position, atol=0.6)
