"""The rim of a sharp lamp, anti-aliased, has the depth of the wall behind and the lamp's light."""

import numpy as np
import pytest

from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.behind import with_behind
from heatlens.render.frame_renderer import FrameRenderer
from support.plates import FAR_M, FOCUS_M, Image, lens_blurring, plate_of

SIDE, FINE = 96, 8
WALL, LAMP = 0.02, 100.0


def lamp_plate(middle: tuple[float, float], radius_px: float):
    """A round lamp in focus before a far wall: colours over each pixel, depth at its centre."""
    at = (np.arange(SIDE * FINE) + 0.5) / FINE
    fine = np.hypot(at[None, :] - middle[0], at[:, None] - middle[1]) < radius_px
    cover = fine.reshape(SIDE, FINE, SIDE, FINE).mean((1, 3))
    grey = (WALL + (LAMP - WALL) * cover).astype(np.float32)
    centre = np.arange(SIDE) + 0.5
    is_lamp = np.hypot(centre[None, :] - middle[0], centre[:, None] - middle[1]) < radius_px
    return plate_of(np.repeat(grey[..., None], 3, -1), np.where(is_lamp, FOCUS_M, FAR_M)), grey


@pytest.mark.parametrize("quality", [Quality.FILM, Quality.DRAFT])
@pytest.mark.parametrize("radius_px", [0.8, 1.3, 2.6, 5.2])
def test_sharp_lamp_keeps_its_light(renderer: FrameRenderer, radius_px, quality):
    """The wall behind is blurred over 20 pixels: none of the light may become such a disc."""
    middle = (48.3, 47.4)
    plate, grey = lamp_plate(middle, radius_px)
    renderer.load(plate)
    lens = lens_blurring(20.0, SIDE)
    found = renderer.pixels(Shot(lens, DefocusSettings(quality=quality)))[..., 0] - WALL
    at = np.arange(SIDE) + 0.5
    near = np.hypot(at[None, :] - middle[0], at[:, None] - middle[1]) < radius_px + 3
    light = float((grey - WALL).sum())
    assert found[near].sum() == pytest.approx(light, rel=0.005)
    assert np.abs(found[~near]).sum() < 0.005 * light


def test_hidden_lamp_leaves_no_specks_at_edge_of_card_before_another(ctx, renderer):
    """Two cards before the focus hide the lamp; the nearer one ends amid the farther one."""
    height, width = 96, 128
    y, x = np.mgrid[:height, :width]
    nearer = x + 0.6 * y < 90
    color = np.where(nearer, 0.2, 0.4).astype(np.float32)[..., None].repeat(3, -1)
    depth_m = np.where(nearer, np.float32(0.8), np.float32(1.3))
    farther = plate_of(np.full_like(color, 0.4), np.full_like(depth_m, 1.3))

    def picture(lamp: float) -> Image:
        wall = np.full_like(color, 0.1)
        wall[46:50, 62:66] = lamp
        behind = [farther, plate_of(wall, np.full_like(depth_m, FAR_M))]
        renderer.load(with_behind(plate_of(color, depth_m), behind))
        return renderer.pixels(Shot(lens_blurring(20.0, width), DefocusSettings()))[..., :3].copy()

    np.testing.assert_allclose(picture(lamp=200.0), picture(lamp=0.1), atol=0.02)
