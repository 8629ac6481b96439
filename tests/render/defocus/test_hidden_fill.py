"""The hidden fill guesses what nearer layers hide, by extending structures behind them."""

import numpy as np

from heatlens.render.defocus.hidden_fill import Ends, HiddenFillPass, HiddenScratch, Steadiness
from heatlens.render.defocus.layer_cuts import NEARER_THAN_ALL, Cut, LayerCut
from heatlens.render.defocus.layer_passes import Layer
from heatlens.render.defocus.line_solver import usual_solver
from heatlens.render.defocus.pixel_list import list_bytes
from heatlens.render.defocus.tile_mask import TileList, VisiblePixels, WholePictures
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import blocks_for
from heatlens.render.gpu.resources import Buffer
from heatlens.render.gpu.textures import FloatArray, download, new_texture, upload

HIDDEN = -1.0  # nothing of the pixel is seen
PADDING_PX = (5, 3)  # a smaller layer is in the corner of its textures


def fill_hidden(
    ctx: Device,
    layer: FloatArray,
    state: FloatArray,
    reach_px: int = 1000,
    shape_share: float | None = None,
) -> tuple[FloatArray, FloatArray]:
    size = layer.shape[1::-1]
    whole = size[0] + PADDING_PX[0], size[1] + PADDING_PX[1]
    mask = WholePictures(ctx).mask(size)
    listed = TileList(ctx.buffer(reserve=TileList.bytes_for(size)))
    target = Layer(new_texture(ctx, whole, 4), new_texture(ctx, whole, 2), size, mask, listed)
    upload(target.color, pad_with_nan(layer))
    upload(target.state, pad_with_nan(state))
    hidden = np.argwhere(layer[..., 3] < 0).astype(np.uint32)
    head = np.array([-(-len(hidden) // 64), 1, 1, len(hidden)], np.uint32)
    pixels = ctx.buffer(reserve=list_bytes(size))
    pixels.write(np.concatenate([head, hidden[:, 0] << 16 | hidden[:, 1]]).tobytes())
    visible = VisiblePixels(*(ctx.buffer(reserve=VisiblePixels.bytes_for(size)) for _ in range(2)))
    cost = new_texture(ctx, blocks_for(whole, 2), 4)
    upload(cost, np.full((*blocks_for(whole, 2)[::-1], 4), np.nan, np.float32))
    has_shapes = shape_share is not None
    lines = Steadiness(*(new_texture(ctx, nodes, 1) for nodes in Steadiness.sizes(whole)))
    scratch = HiddenScratch(
        visible,
        ctx.buffer(reserve=list_bytes(size)),
        cost,
        lines=lines if has_shapes else None,
    )
    fill = HiddenFillPass(ctx, usual_solver(ctx)).steps(
        target,
        pixels,
        scratch,
        reach_px,
        Ends(target.state, LayerCut(NEARER_THAN_ALL, far=Cut(1e9, 1.0))),
        shape_share=shape_share or 0.0,
        each_pixel=has_shapes,
    )
    list(fill)
    check_blocks(scratch.blocks, layer[..., 3] < 0)
    found = download(target.color), download(target.state)
    for texture in found:
        assert np.isnan(texture[size[1] :]).all() and np.isnan(texture[:, size[0] :]).all()
    return found[0][: size[1], : size[0]], found[1][: size[1], : size[0]]


def pad_with_nan(values: FloatArray) -> FloatArray:
    """Return a larger picture with `values` in its corner and NaN elsewhere."""
    margins = ((0, PADDING_PX[1]), (0, PADDING_PX[0]), (0, 0))
    return np.pad(values, margins, constant_values=np.nan)


def check_blocks(blocks: Buffer, hidden: np.ndarray) -> None:
    """Check that the list starts with one pixel of each 2 x 2 block and ends with the others."""
    words = np.frombuffer(blocks.read(), np.uint32)
    first, others = words[12 : 12 + words[3]], words[words.size - words[7] :]
    found = np.stack([first >> 16 & 0x7FFF, first & 0x7FFF], -1) // 2
    expected = np.unique(np.argwhere(hidden) // 2, axis=0)
    np.testing.assert_array_equal(np.unique(found, axis=0), expected)
    assert len(found) == len(expected)
    whole = np.zeros((hidden.shape[0] + 1, hidden.shape[1] + 1), int)
    for word in [*first.tolist(), *others.tolist()]:
        side = 1 + (word >> 31)
        whole[word >> 16 & 0x7FFF :, word & 0x7FFF :][:side, :side] += 1
    np.testing.assert_array_equal(whole[:-1, :-1], hidden)


def layer_with_hole(color: FloatArray, hole: np.ndarray) -> tuple[FloatArray, FloatArray]:
    layer = np.concatenate([color, np.ones((*hole.shape, 1))], axis=-1).astype(np.float32)
    layer[hole] = HIDDEN
    state = np.where(hole[..., None], 0.0, (7.0, 1.0)).astype(np.float32)
    return layer, state


def test_hidden_fill_extends_constant_color(ctx: Device) -> None:
    hole = np.zeros((70, 90), bool)
    hole[20:60, 10:80] = True
    layer, state = layer_with_hole(np.full((70, 90, 3), (0.2, 3.0, 0.5)), hole)
    color, extended = fill_hidden(ctx, layer, state)
    np.testing.assert_allclose(color, np.broadcast_to((0.2, 3.0, 0.5, 1.0), color.shape), rtol=1e-4)
    np.testing.assert_allclose(extended, np.broadcast_to((7.0, 1.0), extended.shape), rtol=1e-4)


def test_hidden_fill_continues_stripes_across_wire(ctx: Device) -> None:
    """Horizontal and diagonal stripes behind an upright wire come back as they were."""
    y, x = np.mgrid[:64, :64]
    hole = (x >= 30) & (x < 34)
    for phase in (y, x + y, x - y):
        color = np.repeat((phase // 8 % 2)[..., None], 3, axis=-1) * 0.8 + 0.1
        result, _ = fill_hidden(ctx, *layer_with_hole(color, hole))
        inner = np.s_[12:52, 30:34]
        wrong = np.abs(result[inner][..., :3] - color[inner]).max(axis=-1) > 0.25
        assert wrong.mean() < 0.12


def test_hidden_fill_continues_dark_bars_behind_wide_surface(ctx: Device) -> None:
    """Bars of a bright window, which meet a leaf on both sides, go on behind it.

    The light behind the leaf is that of the window within 15 %.
    """
    y, x = np.mgrid[:100, :160] + 0.5
    is_bar = (x % 28 < 4) | (y % 37 < 4)
    window = np.where(is_bar[..., None], 0.03, 1.35) * np.ones(3)
    for tilt_degrees, half_axes_px in ((20, (60, 30)), (70, (40, 22)), (45, (60, 16))):
        turned = np.exp(-1j * np.radians(tilt_degrees)) * ((x - 80) + 1j * (y - 50))
        leaf = (turned.real / half_axes_px[0]) ** 2 + (turned.imag / half_axes_px[1]) ** 2 < 1
        guess = fill_hidden(ctx, *layer_with_hole(window, leaf))[0][..., 0]
        assert abs(guess[leaf].mean() / window[leaf].mean() - 1.0) < 0.15
        assert (guess[leaf & is_bar] < 0.7).mean() > 0.6
        assert (guess[leaf & ~is_bar] > 0.7).mean() > 0.9


def test_hidden_fill_continues_bars_that_only_one_side_shows(ctx: Device) -> None:
    """Upright bars go on behind leaves that hide the upper ends, although both panes are nearer.

    The bars are a layer of their own before a farther one, which the panes leave open.
    """
    y, x = np.mgrid[:240, :320] + 0.5
    is_bar = (x % 80 < 8) | (y % 120 < 8)
    coverage = np.where(is_bar, 1.0, 0.0)[..., None]
    layer = np.concatenate([0.03 * coverage.repeat(3, -1), coverage], -1).astype(np.float32)
    for middle_x in (84, 90, 164):
        leaf = ((x - middle_x) / 30) ** 2 + ((y - 20) / 70) ** 2 < 1
        hidden_layer = np.where(leaf[..., None], HIDDEN, layer).astype(np.float32)
        state = np.where(leaf[..., None], 0.0, (0.0, 1.0)).astype(np.float32)
        guess = fill_hidden(ctx, hidden_layer, state, shape_share=1.0)[0][..., 3]
        assert guess[leaf & is_bar & (y % 120 > 8)].mean() > 0.6
        assert guess[leaf & ~is_bar].mean() < 0.05


def test_hidden_bars_have_straight_rims(ctx: Device, rng: np.random.Generator) -> None:
    """The rims of bars behind many small leaves do not change from row to row."""
    y, x = np.mgrid[:200, :320] + 0.5
    coverage = np.where(x % 80 < 9, 1.0, 0.0)[..., None]
    layer = np.concatenate([0.03 * coverage.repeat(3, -1), coverage], -1).astype(np.float32)
    leaves = np.zeros(x.shape, bool)
    for middle_x, middle_y, turn in rng.random((26, 3)) * (320, 200, np.pi):
        offset = ((x - middle_x) + 1j * (y - middle_y)) * np.exp(1j * turn)
        leaves |= (offset.real / 34) ** 2 + (offset.imag / 11) ** 2 < 1
    hidden_layer = np.where(leaves[..., None], HIDDEN, layer).astype(np.float32)
    state = np.where(leaves[..., None], 0.0, (0.0, 1.0)).astype(np.float32)
    guess = fill_hidden(ctx, hidden_layer, state, shape_share=1.0)[0][..., 3]
    wrong = np.abs(guess - coverage[..., 0]) > 0.5
    rims = leaves & (np.abs((x + 40) % 80 - 44.5) < 8)
    assert wrong[rims].mean() < 0.02


def test_hidden_fill_crosses_gap_longer_than_mask_word(ctx: Device) -> None:
    hole = np.zeros((3, 300), bool)
    hole[:, 5:290] = True
    color = np.zeros((3, 300, 3))
    color[:, 290:] = 1.0
    result, _ = fill_hidden(ctx, *layer_with_hole(color, hole))
    row = result[1, 5:290, 0]
    assert np.all(np.diff(row) >= 0) and row[0] < 0.05 and row[-1] > 0.9


def test_hidden_fill_by_lines_is_finite_far_from_all_ends(ctx: Device) -> None:
    hole = np.zeros((4, 640), bool)
    hole[:, 20:620] = True
    layer, state = layer_with_hole(np.full((4, 640, 3), 0.5), hole)
    color, diameter = fill_hidden(ctx, layer, state, shape_share=1e-6)
    assert np.isfinite(diameter).all()
    np.testing.assert_allclose(color[..., :3], 0.5, atol=0.01)


def test_hidden_fill_without_seen_pixels_is_empty(ctx: Device) -> None:
    hole = np.ones((9, 11), bool)
    color, state = fill_hidden(ctx, *layer_with_hole(np.zeros((9, 11, 3)), hole))
    assert np.all(color == 0.0) and np.all(state == 0.0)


def test_hidden_fill_does_not_change_seen_pixels(ctx: Device, rng: np.random.Generator) -> None:
    hole = rng.random((33, 47)) < 0.3
    layer, state = layer_with_hole(rng.random((33, 47, 3)), hole)
    color, extended = fill_hidden(ctx, layer, state)
    assert np.array_equal(color[~hole], layer[~hole])
    assert np.array_equal(extended[~hole], state[~hole])
    assert color[hole][:, 3].min() > 0.99


def test_pixels_mostly_known_do_not_change_which_guesses_are_shared(
    ctx: Device, rng: np.random.Generator
) -> None:
    """A column behind the right rim of a hole, of which the layer knows 3/4, is being released.

    As blocks of 2 x 2 pixels in the hole shared a guess because of it, a window flashed by 16.8
    levels behind a leaf.
    """
    hole = np.zeros((32, 64), bool)
    hole[:, 20:39] = True
    layer, state = layer_with_hole(rng.random((32, 1, 1)) * np.ones((32, 64, 3)), hole)
    passing = layer.copy()
    passing[:, 40, 3] = -1.0 - 1.0 - 4.0 * 192.0  # covered, 192/256 known (lib/hidden.lib.glsl)
    shared = []
    for each in (layer, passing):
        filled = fill_hidden(ctx, each, state)[0][:, 20:39, 0]
        shared.append(filled[::2] == filled[1::2])
    assert np.array_equal(*shared)
    assert 0.2 < shared[0].mean() < 0.8


def test_hidden_fill_beyond_reach_stays_empty(ctx: Device) -> None:
    hole = np.zeros((60, 60), bool)
    hole[5:55, 5:55] = True
    color, state = fill_hidden(ctx, *layer_with_hole(np.full((60, 60, 3), 0.5), hole), reach_px=10)
    assert np.all(color[17:43, 17:43] == 0.0) and np.all(state[17:43, 17:43, 1] == 0.0)
    expected = np.broadcast_to((0.5, 0.5, 0.5, 1.0), (8, 20, 4))
    np.testing.assert_allclose(color[6:14, 20:40], expected, rtol=1e-4)


def test_hidden_fill_is_smoother_for_larger_blur(ctx: Device, rng: np.random.Generator) -> None:
    """Pixels that a blur will mix are filled by a mean of seen pixels, not by the nearest one."""
    y, x = np.mgrid[:80, :80]
    hole = (abs(x - 40) < 8) & (abs(y - 40) < 8)
    layer, state = layer_with_hole(np.repeat(rng.random((80, 80, 1)), 3, axis=-1), hole)
    spreads = []
    for diameter_px in (1.0, 8.0, 20.0, 60.0):
        state[~hole, 0] = diameter_px
        guess = fill_hidden(ctx, layer, state)[0][hole][:, 0]
        assert abs(guess.mean() - 0.5) < 0.05
        spreads.append(guess.std())
    assert np.all(np.diff(spreads) < 0) and spreads[-1] < 0.6 * spreads[0]


def test_hidden_fill_is_never_brighter_than_seen_pixels(
    ctx: Device, rng: np.random.Generator
) -> None:
    hole = rng.random((40, 50)) < 0.4
    layer, state = layer_with_hole(rng.exponential(3.0, (40, 50, 3)), hole)
    state[~hole, 0] = 60.0
    color, _ = fill_hidden(ctx, layer, state)
    seen = layer[~hole][:, :3].mean(axis=1)
    assert color[hole][:, :3].mean(axis=1).max() <= seen.max() * 1.001


def test_single_lamp_at_edge_does_not_light_hidden_region(ctx: Device) -> None:
    hole = np.zeros((60, 60), bool)
    hole[20:40, 20:40] = True
    color = np.full((60, 60, 3), 0.2)
    color[30, 19] = 300.0
    result, _ = fill_hidden(ctx, *layer_with_hole(color, hole))
    assert result[30, 22:38, 0].max() < 2.0
