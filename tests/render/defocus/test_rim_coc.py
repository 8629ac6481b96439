"""Inside a layer a silhouette has the nearer surface's blur on both sides; beyond it, its own."""

import numpy as np
import pytest

from heatlens.render.defocus.layer_cuts import Cut, LayerCut
from heatlens.render.defocus.layer_passes import CocFillPass
from heatlens.render.defocus.line_solver import (
    CyclicSolver,
    LineSolver,
    PartitionSolver,
    SweepSolver,
)
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import FloatArray, download, new_texture, upload

NEAR = LayerCut(near=Cut(-62.5, 6.0), far=Cut(-10.0, 1.0), is_before_focus=True)
FAR = LayerCut(near=Cut(10.0, 2.0), far=Cut(80.0, 2.0))
SHAPE = (48, 128)


@pytest.fixture(params=[SweepSolver, PartitionSolver, CyclicSolver])
def solver(ctx: Device, request: pytest.FixtureRequest) -> LineSolver:
    return request.param(ctx)


def filled(
    ctx: Device,
    solver: LineSolver,
    diameter: FloatArray,
    known: FloatArray,
    cut: LayerCut,
) -> FloatArray:
    """Return the coc of a layer with this (H, W) diameter as far as it is known, 0..1."""
    size = diameter.shape[1::-1]
    state, out = new_texture(ctx, size, 2), new_texture(ctx, size, 1)
    rows = tuple(ctx.buffer(reserve=CocFillPass.rows_bytes(size)) for _ in range(2))
    upload(state, np.stack([diameter, known], axis=-1).astype(np.float32))
    list(CocFillPass(solver).steps(state, cut, (1.0, 1.0), rows, out))
    return download(out).reshape(diameter.shape)


def halves(left_px: float, right_px: float) -> FloatArray:
    return np.where(np.arange(SHAPE[1]) < 64, left_px, right_px) * np.ones(SHAPE)


@pytest.mark.parametrize(("cut", "nearer_px", "farther_px"), [(NEAR, 24, 16), (FAR, 22, 30)])
def test_a_silhouette_has_the_nearer_blur_on_both_sides(
    ctx: Device, solver: LineSolver, cut: LayerCut, nearer_px: float, farther_px: float
) -> None:
    out = filled(ctx, solver, halves(nearer_px, farther_px), np.ones(SHAPE), cut)[24]
    np.testing.assert_allclose(out[:64], nearer_px, rtol=1e-4)
    assert abs(out[64] - nearer_px) < 0.25 * abs(farther_px - nearer_px)
    assert np.all(np.diff(np.abs(out[64:] - nearer_px)) >= -1e-3)
    assert out[-1] == pytest.approx(farther_px, rel=0.02)


@pytest.mark.parametrize("cut", [NEAR, FAR])
def test_diameters_stay_within_the_limit(
    ctx: Device, solver: LineSolver, rng: np.random.Generator, cut: LayerCut
) -> None:
    diameter = rng.uniform(5, 60, SHAPE)
    part = filled(ctx, solver, diameter, np.ones(SHAPE), cut) / diameter
    low, high = (1.0, 1 / 0.6) if cut is NEAR else (0.6, 1.0)
    assert part.min() > low - 1e-4 and part.max() < high + 1e-4
    assert np.ptp(part) > 0.2


@pytest.mark.parametrize("cut", [NEAR, FAR])
def test_what_is_in_focus_stays_and_lets_nothing_through(
    ctx: Device, solver: LineSolver, cut: LayerCut
) -> None:
    diameter = halves(0, 30)
    out = filled(ctx, solver, diameter, np.ones(SHAPE), cut)
    np.testing.assert_array_equal(out[:, :64], 0)
    np.testing.assert_allclose(out[:, 64:], 30, rtol=1e-4)


def test_beyond_the_content_its_edge_goes_on(ctx: Device, solver: LineSolver) -> None:
    """Not a mean with what lies further in, though that diffuses into the edge."""
    ramp = np.linspace(60, 20, SHAPE[1]) * np.ones(SHAPE)
    known = halves(1, 0)
    row = filled(ctx, solver, ramp, known, NEAR)[24]
    np.testing.assert_allclose(row[64:96], ramp[24, 63], rtol=0.01)
