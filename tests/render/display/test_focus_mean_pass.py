"""FocusMeanPass: the mean color of the plate's pixels in focus, at the size of a preview."""

import numpy as np
import pytest

from heatlens.core.model.focus.coc import CocLine
from heatlens.render.display.picture_pass import CoarsePlate, DepthRangePass, FocusMeanPass
from heatlens.render.gpu.textures import download, new_texture, upload

SMALL, TIMES = (6, 4), 5
LINE = CocLine(at_infinity_px=50.0, per_dioptre_px=-100.0)


def focus_mean(ctx, color: np.ndarray, coc: np.ndarray, line: CocLine | None = None) -> np.ndarray:
    """Return the mean of a picture (H, W, 4) with its coc (H, W) in pixels, and the share."""
    depth = coc if line is None else line.per_dioptre_px / (coc - line.at_infinity_px)
    size = color.shape[1::-1]
    textures = new_texture(ctx, size, 4), new_texture(ctx, size, 1)
    mean, out = new_texture(ctx, SMALL, 4), new_texture(ctx, SMALL, 4)
    for texture, values in zip((*textures, mean), (color, depth, blocks(color)), strict=True):
        upload(texture, values.astype(np.float32))
    depth_range = new_texture(ctx, SMALL, 4)
    DepthRangePass(ctx).run(textures[1], depth_range)
    FocusMeanPass(ctx).run(*textures, line, CoarsePlate(mean, depth_range), out)
    return download(out)


def blocks(values: np.ndarray) -> np.ndarray:
    """Return the mean of each block of pixels under a pixel of the preview."""
    return values.reshape(SMALL[1], TIMES, SMALL[0], TIMES, -1).mean(axis=(1, 3))


@pytest.fixture
def color(rng) -> np.ndarray:
    return rng.random((SMALL[1] * TIMES, SMALL[0] * TIMES, 4))


@pytest.mark.parametrize("line", [None, LINE])
def test_focus_mean_weights_pixels_by_focus(ctx, rng, color, line):
    coc = rng.choice([0.0, -1.0, 4.0, -6.0, 30.0], color.shape[:2])
    t = np.clip(np.abs(coc) / TIMES - 0.5, 0, 1)
    share = (1 - t * t * (3 - 2 * t))[..., None]
    expected = blocks(share * color) / blocks(share)
    found = focus_mean(ctx, color, coc, line)
    np.testing.assert_allclose(found[..., :3], expected[..., :3], atol=1e-4)
    np.testing.assert_array_equal(found[..., 3], 1.0)  # 0 and -1 pixel, or both sides of the focus


@pytest.mark.parametrize("line", [None, LINE])
@pytest.mark.parametrize("coc_px", [0.0, 4.0, -5.0, 30.0])
def test_alpha_of_focus_mean_is_greatest_share(ctx, color, line, coc_px):
    coc = np.full(color.shape[:2], 40.0)
    coc[::TIMES, ::TIMES] = coc_px  # one pixel under each of the preview
    t = np.clip(abs(coc_px) / TIMES - 0.5, 0, 1)
    expected = 1 - t * t * (3 - 2 * t)
    found = focus_mean(ctx, color, coc, line)[..., 3]
    if coc_px < 0 and expected > 0:  # the focus lies between the pixels
        expected = 1.0
    np.testing.assert_allclose(found, expected, atol=1e-4)


def test_focus_between_blurred_pixels_is_no_share(ctx, color):
    coc = np.full(color.shape[:2], 40.0)
    coc[::TIMES, ::TIMES] = -40.0
    found = focus_mean(ctx, color, coc)
    np.testing.assert_allclose(found[..., :3], blocks(color)[..., :3], atol=1e-6)
    np.testing.assert_array_equal(found[..., 3], 0.0)


@pytest.mark.parametrize("coc_px", [0.0, 2.0, -40.0])
def test_focus_mean_is_plain_mean_for_equal_coc(ctx, color, coc_px):
    focused_mean = focus_mean(ctx, color, np.full(color.shape[:2], coc_px))
    np.testing.assert_allclose(focused_mean[..., :3], blocks(color)[..., :3], atol=1e-6)


def test_focus_mean_excludes_blurred_pixels_beside_sharp_ones(ctx, rng, color):
    coc = np.zeros(color.shape[:2])
    coc[:, ::2] = -30.0  # in each pixel of the preview
    repainted = color.copy()
    repainted[:, ::2] = rng.random(repainted[:, ::2].shape)
    before, after = (focus_mean(ctx, it, coc) for it in (color, repainted))
    np.testing.assert_array_equal(before, after)
