"""Bright and soft disc rims in pictures blurred by diffusion."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.focus.coc import coc_line, coc_px
from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import FloatArray
from support.plates import FAR_M, NEAR_M, lens_blurring, plate_of

SIDE, COC_PX = 96, 32.0


def disc_of(renderer: FrameRenderer, depth_m: float, rim: float) -> tuple[FloatArray, float]:
    """Return the light of a blurred dot, too dim to be drawn as a lamp, above a wall; and its coc.

    The light is (SIDE, SIDE), the coc in pixels.
    """
    wall = np.ones((SIDE, SIDE, 3), np.float32)
    wall[SIDE // 2, SIDE // 2] = 2.5
    renderer.load(plate_of(wall, np.full((SIDE, SIDE), depth_m, np.float32)))
    lens = replace(lens_blurring(COC_PX, SIDE), rim=rim)
    picture = renderer.pixels(Shot(lens, DefocusSettings(quality=Quality.FILM)))
    return picture[..., 1] - 1.0, float(coc_px(depth_m, coc_line(lens, SIDE)))


@pytest.mark.parametrize(("depth_m", "rim"), [(FAR_M, 0.8), (NEAR_M, -0.8), (FAR_M, -0.8)])
def test_rim_is_bright_on_its_side_of_focus_and_soft_on_other(
    ctx: Device, renderer: FrameRenderer, depth_m: float, rim: float
) -> None:
    """Check a bright rim behind the focus if `rim` is positive, before the focus if negative."""
    light, coc = disc_of(renderer, depth_m, rim)
    y, x = np.indices(light.shape) - SIDE // 2
    relative_radius = np.hypot(x, y) / (abs(coc) / 2)
    inner, outer = (
        light[relative_radius < 0.4].mean(),
        light[(relative_radius > 0.7) & (relative_radius < 0.95)].mean(),
    )
    is_bright = (coc > 0) == (rim > 0)
    assert outer > 2.0 * inner if is_bright else inner > 2.0 * outer
    # The kernels' own ripple beyond the disc, on a picture whose border some of it is turned at.
    assert light.sum(dtype=np.float64) == pytest.approx(1.5, rel=0.01)
