"""CocFillPass: at a silhouette in a layer both sides get the nearer surface's coc."""

import numpy as np
import pytest

from heatlens.render.defocus.layer_cuts import Cut, LayerCut
from heatlens.render.defocus.layer_passes import CocFillPass
from heatlens.render.defocus.line_solver import (
    LineSolver,
    PartitionSolver,
    SweepSolver,
)
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import FloatArray, download, new_texture, upload

NEAR = LayerCut(near=Cut(-62.5, 6.0), far=Cut(-10.0, 1.0), is_before_focus=True)
FAR = LayerCut(near=Cut(10.0, 2.0), far=Cut(80.0, 2.0))
SHAPE = (48, 128)


@pytest.fixture(params=[SweepSolver, PartitionSolver])
def solver(ctx: Device, request: pytest.FixtureRequest) -> LineSolver:
    return request.param(ctx)


def fill_coc(
    ctx: Device, solver: LineSolver, diameter: FloatArray, known: FloatArray, cut: LayerCut
) -> FloatArray:
    """Return the filled coc of a layer; `diameter` (H, W) in px, `known` its share known, 0..1."""
    size = diameter.shape[1::-1]
    state, out = new_texture(ctx, size, 2), new_texture(ctx, size, 1)
    rows = tuple(ctx.buffer(reserve=CocFillPass.rows_bytes(size)) for _ in range(2))
    upload(state, np.stack([diameter, known], axis=-1).astype(np.float32))
    list(CocFillPass(solver).steps(state, cut, (1.0, 1.0), rows, out))
    return download(out).reshape(diameter.shape)


def two_halves(left_px: float, right_px: float) -> FloatArray:
    return np.where(np.arange(SHAPE[1]) < 64, left_px, right_px) * np.ones(SHAPE)


@pytest.mark.parametrize(("cut", "nearer_px", "farther_px"), [(NEAR, 24, 16), (FAR, 22, 30)])
def test_coc_fill_gives_silhouette_nearer_coc_on_both_sides(
    ctx: Device, solver: LineSolver, cut: LayerCut, nearer_px: float, farther_px: float
) -> None:
    out = fill_coc(ctx, solver, two_halves(nearer_px, farther_px), np.ones(SHAPE), cut)[24]
    np.testing.assert_allclose(out[:64], nearer_px, rtol=1e-4)
    assert abs(out[64] - nearer_px) < 0.25 * abs(farther_px - nearer_px)
    assert np.all(np.diff(np.abs(out[64:] - nearer_px)) >= -1e-3)
    assert out[-1] == pytest.approx(farther_px, rel=0.02)


@pytest.mark.parametrize("cut", [NEAR, FAR])
def test_coc_fill_changes_diameters_within_limit(
    ctx: Device, solver: LineSolver, rng: np.random.Generator, cut: LayerCut
) -> None:
    diameter = rng.uniform(5, 60, SHAPE)
    ratio = fill_coc(ctx, solver, diameter, np.ones(SHAPE), cut) / diameter
    low, high = (1.0, 1 / 0.6) if cut is NEAR else (0.6, 1.0)
    assert ratio.min() > low - 1e-4 and ratio.max() < high + 1e-4
    assert np.ptp(ratio) > 0.2


@pytest.mark.parametrize("cut", [NEAR, FAR])
def test_coc_fill_keeps_pixels_in_focus_and_does_not_cross_them(
    ctx: Device, solver: LineSolver, cut: LayerCut
) -> None:
    diameter = two_halves(0, 30)
    out = fill_coc(ctx, solver, diameter, np.ones(SHAPE), cut)
    np.testing.assert_array_equal(out[:, :64], 0)
    np.testing.assert_allclose(out[:, 64:], 30, rtol=1e-4)


def test_coc_fill_extends_edge_coc_beyond_content(ctx: Device, solver: LineSolver) -> None:
    """Check that the fill repeats the edge's coc, though values further inside diffuse into it."""
    ramp = np.linspace(60, 20, SHAPE[1]) * np.ones(SHAPE)
    known = two_halves(1, 0)
    row = fill_coc(ctx, solver, ramp, known, NEAR)[24]
    np.testing.assert_allclose(row[64:96], ramp[24, 63], rtol=0.01)


def test_coc_fill_leaves_a_rim_beside_nothing_as_it_is(ctx: Device, solver: LineSolver) -> None:
    """Extend a small thing with less blur past the upper rim of a wide one.

    What was extended counted as a nearer surface: the rim had 0.6 of its blur.
    """
    rows, columns = np.indices(SHAPE)
    is_small, is_wide = (columns < 8) & (rows < 16), rows >= 20
    diameter = np.where(is_small, 2.0, 8.0)
    out = fill_coc(ctx, solver, diameter, is_small | is_wide, FAR)
    np.testing.assert_allclose(out[20:, 64:], 8.0, rtol=0.02)
