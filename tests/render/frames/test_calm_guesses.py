"""What is guessed behind a blurred foreground is calm: no light of lamps, no jumps in a pull."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from support.plates import FOCUS_M, Image, lens_blurring, plate_of
from support.unrest import flash, unrest

HEIGHT, WIDTH, EDGE = 96, 128, 64
LEAF_M, FLAME_M, WALL_M = 1.0, FOCUS_M, 6.0
LAMP = 200.0


def flame_by_a_leaf(light: float) -> tuple[Image, Image]:
    """Return colour and depth of a flame in front of a wall, half behind a dark leaf at the left.

    Anti-aliased in colour and one sample in depth, as a renderer writes it.
    """
    finer = 4
    y, x = (np.mgrid[: finer * HEIGHT, : finer * WIDTH] + 0.5).astype(np.float32) / finer
    color = np.full((*x.shape, 3), 0.08, np.float32)
    depth_m = np.full(x.shape, WALL_M, np.float32)
    flame = np.hypot(x - EDGE - 0.4, y - HEIGHT / 2) < 2.6
    color[flame], depth_m[flame] = light * np.float32([1.0, 0.7, 0.3]), FLAME_M
    leaf = x < EDGE
    color[leaf], depth_m[leaf] = (0.02, 0.06, 0.02), LEAF_M
    mean = color.reshape(HEIGHT, finer, WIDTH, finer, 3).mean((1, 3))
    return mean, depth_m[finer // 2 :: finer, finer // 2 :: finer]


def pulled(renderer, frames: int = 12) -> list[Image]:
    """Pull through the flame."""
    renderer.load(plate_of(*flame_by_a_leaf(LAMP)))
    distances_m = 1.0 / np.linspace(1 / 1.7, 1 / 2.4, frames)
    return [through(renderer, float(distance_m)) for distance_m in distances_m]


def through(renderer, focus_m: float) -> Image:
    """Return what is loaded through the lens that is 24 px blurred at FAR_M from FOCUS_M."""
    lens = replace(lens_blurring(24.0, WIDTH), focus_distance_m=focus_m)
    return renderer.pixels(Shot(lens, DefocusSettings()))[..., :3].copy()


def test_a_flame_in_focus_leaves_no_light_behind_the_leaf(ctx, renderer):
    """The leaf is dark, and all that is guessed behind it is as dim as the wall."""
    renderer.load(plate_of(*flame_by_a_leaf(LAMP)))
    picture = through(renderer, FOCUS_M)
    assert picture[:, : EDGE - 4].max() < 0.5
    assert picture[HEIGHT // 2, EDGE + 1].mean() > 0.2 * LAMP


def test_a_pull_through_a_flame_behind_a_leaf_is_calm(ctx, renderer):
    assert unrest(pulled(renderer)) < 2.0


def test_a_surface_that_passes_from_layer_to_layer_is_calm(ctx, renderer):
    """A card before a wall: in the pull it leaves the wall's layer for that in front of it.

    Handed on in a seventh of the cut's transition, the card made this pull jump by 84.
    """
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    card = (abs(x - WIDTH / 2 + 0.5) < 24) & (abs(y - HEIGHT / 2 + 0.5) < 20)
    color = np.where(card[..., None], 0.8, 0.1).repeat(3, axis=-1)
    renderer.load(plate_of(color, np.where(card, 2.6, WALL_M)))
    distances_m = 1.0 / np.linspace(1 / 1.85, 1 / 2.3, 30)
    assert unrest([through(renderer, float(distance_m)) for distance_m in distances_m]) < 20.0


@pytest.mark.parametrize("focus_m", [1.9, FOCUS_M, 2.1])
def test_the_rim_of_a_flame_has_the_blur_of_the_flame(ctx, renderer, focus_m):
    """No pixel is lit but those near the flame; its rim shows a leaf blurred by 50 pixels."""
    renderer.load(plate_of(*flame_by_a_leaf(LAMP)))
    lit = through(renderer, focus_m)
    renderer.load(plate_of(*flame_by_a_leaf(0.08)))
    dark = through(renderer, focus_m)
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    coc_px = 48.0 * abs(1 - focus_m / FLAME_M)
    away = np.hypot(x - EDGE, y - HEIGHT / 2) > 5.0 + coc_px / 2 + 2.0
    assert (lit - dark)[away].max() < 1.0


def vase_and_ball(height: int = 180, width: int = 320) -> tuple[Image, Image]:
    """Return colour and depth of a large round vase near the left border, a ball and a wall."""
    rng = np.random.default_rng(3)

    def pattern(step: int) -> Image:
        cells = rng.random((height // step + 1, width // step + 1, 3))
        return np.kron(cells, np.ones((step, step, 1)))[:height, :width]

    y, x = np.mgrid[:height, :width]
    color, depth_m = 0.6 * pattern(6), np.full((height, width), WALL_M)
    ball = (x - 210) ** 2 + (y - 100) ** 2 < 45**2
    color[ball], depth_m[ball] = (0.2 + 0.6 * pattern(9))[ball], 2.5
    across = np.abs(x - 90) / (45 + 25 * np.sin(y / 28))
    vase = across < 1
    color[vase] = (0.1 + 0.5 * pattern(12))[vase]
    depth_m[vase] = (1.0 - 0.12 * np.sqrt(np.maximum(1 - across**2, 0)))[vase]
    return color.astype(np.float32), depth_m.astype(np.float32)


def test_a_pull_behind_a_large_near_vase_is_calm(ctx, renderer):
    """From the ball's front to the wall: no cut, and no bend of the blur, shows on the way."""
    renderer.load(plate_of(*vase_and_ball()))
    shots = [
        Shot(Lens(50.0, 1.4, float(1 / dioptres), 36.0), DefocusSettings())
        for dioptres in np.linspace(1 / 2, 1 / WALL_M, 40)
    ]
    frames = [renderer.pixels(shot)[..., :3].copy() for shot in shots]
    assert unrest(frames) < 1.8
    assert flash(frames) < 1.5


def test_a_wall_that_comes_into_focus_behind_a_post_is_calm(ctx, renderer):
    """It leaves the far layer on the way; all that is known of it behind the post goes along.

    Given back by the far layer before the nearer one covered it, it was dark behind the post.
    """
    rng = np.random.default_rng(5)
    color = np.kron(0.3 + 0.3 * rng.random((16, 22, 3)), np.ones((6, 6, 1)))[:HEIGHT, :WIDTH]
    is_post = np.abs(np.arange(WIDTH) - 60) < 8
    color[:, is_post] = 0.1
    depth_m = np.broadcast_to(np.where(is_post, LEAF_M, WALL_M), (HEIGHT, WIDTH))
    renderer.load(plate_of(color.astype(np.float32), depth_m.astype(np.float32)))
    distances_m = 1.0 / np.linspace(1 / 5.0, 1 / 5.9, 30)
    assert unrest([through(renderer, float(distance_m)) for distance_m in distances_m]) < 4.0


def test_a_wall_that_comes_into_focus_behind_wires_is_calm(ctx, renderer):
    """It passes the far cut slowly: what is guessed behind the wires changes with the layer.

    Passed in three quarters of that range, the wall made this pull jump by 1.66.
    """
    rng = np.random.default_rng(5)
    color = np.kron(0.3 + 0.5 * rng.random((24, 32, 3)), np.ones((4, 4, 1)))
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    is_wire = ((x + y) % 12 == 0) | ((x - y) % 12 == 0)
    color[is_wire] = 0.5
    depth_m = np.where(is_wire, 3.0, WALL_M)
    renderer.load(plate_of(color.astype(np.float32), depth_m.astype(np.float32)))
    distances_m = 1.0 / np.linspace(1 / 4.5, 1 / 5.9, 30)
    assert unrest([through(renderer, float(distance_m)) for distance_m in distances_m]) < 1.58
