"""Fill guessed behind a blurred foreground: no light of lamps, no jumps in a focus pull."""

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


def render_pull(renderer, frames: int = 12) -> list[Image]:
    """Return the frames of a focus pull from 1.7 m to 2.4 m past the flame."""
    renderer.load(plate_of(*flame_by_a_leaf(LAMP)))
    distances_m = 1.0 / np.linspace(1 / 1.7, 1 / 2.4, frames)
    return [render_at_focus(renderer, float(distance_m)) for distance_m in distances_m]


def render_at_focus(renderer, focus_m: float) -> Image:
    """Render the loaded plate at `focus_m`; focused at FOCUS_M, the lens has 24 px coc at FAR_M."""
    lens = replace(lens_blurring(24.0, WIDTH), focus_distance_m=focus_m)
    return renderer.pixels(Shot(lens, DefocusSettings()))[..., :3].copy()


def test_flame_in_focus_adds_no_light_behind_leaf(ctx, renderer):
    """Check that the dark leaf stays dark: the fill guessed behind it is as dim as the wall."""
    renderer.load(plate_of(*flame_by_a_leaf(LAMP)))
    picture = render_at_focus(renderer, FOCUS_M)
    assert picture[:, : EDGE - 4].max() < 0.5
    assert picture[HEIGHT // 2, EDGE + 1].mean() > 0.2 * LAMP


def test_focus_pull_past_flame_behind_leaf_has_no_jumps(ctx, renderer):
    assert unrest(render_pull(renderer)) < 2.0


def test_focus_pull_of_card_changing_its_layer_has_no_jumps(ctx, renderer):
    """Pull focus so that a card passes from the wall's layer to the one in front of it.

    When a card changed its layer within a seventh of the cut's transition, the unrest was 84.
    """
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    card = (abs(x - WIDTH / 2 + 0.5) < 24) & (abs(y - HEIGHT / 2 + 0.5) < 20)
    color = np.where(card[..., None], 0.8, 0.1).repeat(3, axis=-1)
    renderer.load(plate_of(color, np.where(card, 2.6, WALL_M)))
    distances_m = 1.0 / np.linspace(1 / 1.85, 1 / 2.3, 30)
    assert (
        unrest([render_at_focus(renderer, float(distance_m)) for distance_m in distances_m]) < 20.0
    )


@pytest.mark.parametrize("focus_m", [1.9, FOCUS_M, 2.1])
def test_edge_of_flame_before_leaf_has_coc_of_flame(ctx, renderer, focus_m):
    """Check that only pixels near the flame are lit, though the leaf at its edge has 50 px coc."""
    renderer.load(plate_of(*flame_by_a_leaf(LAMP)))
    lit = render_at_focus(renderer, focus_m)
    renderer.load(plate_of(*flame_by_a_leaf(0.08)))
    dark = render_at_focus(renderer, focus_m)
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


def test_focus_pull_behind_near_vase_has_no_jumps(ctx, renderer):
    """Pull focus from the ball's front to the wall: no cut and no bend of the blur is visible."""
    renderer.load(plate_of(*vase_and_ball()))
    shots = [
        Shot(Lens(50.0, 1.4, float(1 / dioptres), 36.0), DefocusSettings())
        for dioptres in np.linspace(1 / 2, 1 / WALL_M, 40)
    ]
    frames = [renderer.pixels(shot)[..., :3].copy() for shot in shots]
    assert unrest(frames) < 1.8
    assert flash(frames) < 1.5


def test_focus_pull_to_wall_behind_post_has_no_jumps(ctx, renderer):
    """Pull focus so that the wall leaves the far layer with all that is known behind the post.

    Released by the far layer before the nearer one covered it, the wall was dark behind the post.
    """
    rng = np.random.default_rng(5)
    color = np.kron(0.3 + 0.3 * rng.random((16, 22, 3)), np.ones((6, 6, 1)))[:HEIGHT, :WIDTH]
    is_post = np.abs(np.arange(WIDTH) - 60) < 8
    color[:, is_post] = 0.1
    depth_m = np.broadcast_to(np.where(is_post, LEAF_M, WALL_M), (HEIGHT, WIDTH))
    renderer.load(plate_of(color.astype(np.float32), depth_m.astype(np.float32)))
    distances_m = 1.0 / np.linspace(1 / 5.0, 1 / 5.9, 30)
    assert (
        unrest([render_at_focus(renderer, float(distance_m)) for distance_m in distances_m]) < 4.0
    )


def test_focus_pull_to_wall_behind_wires_has_no_jumps(ctx, renderer):
    """Pull focus so that the wall passes the far cut: the fill behind the wires changes with it.

    Passed in three quarters of that range, the wall made this pull jump by 1.66. With the full
    weight for its pixels beside the wires and for the guess behind them, the unrest was 3.29.
    """
    rng = np.random.default_rng(5)
    color = np.kron(0.3 + 0.5 * rng.random((24, 32, 3)), np.ones((4, 4, 1)))
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    is_wire = ((x + y) % 12 == 0) | ((x - y) % 12 == 0)
    color[is_wire] = 0.5
    depth_m = np.where(is_wire, 3.0, WALL_M)
    renderer.load(plate_of(color.astype(np.float32), depth_m.astype(np.float32)))
    distances_m = 1.0 / np.linspace(1 / 4.5, 1 / 5.9, 30)
    assert (
        unrest([render_at_focus(renderer, float(distance_m)) for distance_m in distances_m]) < 1.58
    )
