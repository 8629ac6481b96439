"""Strongly blurred layers are computed at reduced size: when, and how little that changes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import LAYERS_MAX, DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.render.defocus import layer_plan
from heatlens.render.defocus.layer_cuts import layer_cuts
from heatlens.render.defocus.layer_plan import (
    LEAST_REDUCED_PX,
    LEAST_REDUCED_SIDE,
    LayerPlan,
    layer_plans,
)
from heatlens.render.defocus.optics import Optics
from heatlens.render.frame_renderer import FrameRenderer
from support.layers import ladder_of
from support.plates import FAR_M, NEAR_M, Image, lens_blurring, moments, plate_of, room

COCS = st.lists(st.floats(-500, 500), min_size=1, max_size=40).map(lambda v: np.sort(np.array(v)))
LARGE = (1920, 1080)


def layer_plans_of(coc: np.ndarray, size: tuple[int, int] = LARGE) -> list[LayerPlan]:
    optics = Optics(None, coc)
    return layer_plans(ladder_of(coc), optics, size)


@given(COCS)
def test_reduced_layer_has_least_coc_in_reduced_pixels(coc: np.ndarray) -> None:
    for plan in layer_plans_of(coc):
        low, high = plan.coc_range_px
        layer_coc_px = np.abs(coc[(coc > low) & (coc < high)])
        assert plan.reduction == 1 or layer_coc_px.min() >= plan.reduction * LEAST_REDUCED_PX


@given(COCS, st.floats(-500, 500))
def test_near_layer_reduction_ignores_coc_of_other_layers(
    coc: np.ndarray, added_coc_px: float
) -> None:
    """Check that a new coc value in any layer leaves the reduction of the near layers unchanged."""
    before, after = (
        {
            plan.coc_range_px: plan.reduction
            for plan in layer_plans_of(np.sort(cocs))
            if plan.coc_range_px[1] < 0
        }
        for cocs in (coc, np.append(coc, added_coc_px))
    )
    for ends in before.keys() & after.keys():
        assert before[ends] == after[ends]


@given(COCS, st.integers(1, 200), st.integers(1, 200))
def test_reduced_layer_covers_picture_and_keeps_least_side(coc, width, height) -> None:
    for plan in layer_plans_of(coc, (width, height)):
        across, down = plan.size((width, height))
        assert 0 <= across * plan.reduction - width < plan.reduction
        assert 0 <= down * plan.reduction - height < plan.reduction
        assert plan.reduction == 1 or min(width, height) >= LEAST_REDUCED_SIDE * plan.reduction


def test_resampled_px_2_is_variance_of_resampling() -> None:
    """Compare with the variance of points reduced by a box filter and enlarged linearly."""
    for reduction in (2, 4, 8):
        variances = []
        for position in range(8 * reduction, 9 * reduction):
            line = np.zeros(17 * reduction)
            line[position] = 1.0
            small = line.reshape(-1, reduction).mean(axis=1)
            centres = reduction * (np.arange(len(small)) + 0.5) - 0.5
            large = np.interp(np.arange(len(line)), centres, small)
            x = np.arange(len(line)) - position
            variances.append((large * x**2).sum() / large.sum())
        plan = LayerPlan(ladder_of(np.array([200.0]))[0], reduction, 200.0, 200.0)
        expected = plan.resampled_px_2 / 16 * reduction**2
        assert np.mean(variances) == pytest.approx(expected, rel=0.35, abs=0.1)


def render_plate(renderer: FrameRenderer, color: Image, depth: Image, lens: Lens) -> Image:
    renderer.load(plate_of(color, depth))
    return renderer.pixels(Shot(lens, DefocusSettings()))[..., :3]


@pytest.mark.parametrize(
    ("coc_px", "depth_m"),
    [(27.0, NEAR_M), (55.0, NEAR_M), (120.0, NEAR_M), (61.0, FAR_M), (120.0, FAR_M)],
)
def test_reduced_layer_blurs_like_layer_at_full_size(
    ctx, renderer, rng, monkeypatch, coc_px, depth_m
):
    """Compare random squares: within 0.03 everywhere, 0.012 inside, the mean within 1e-3."""
    color = np.repeat(np.repeat(rng.random((64, 80, 3), np.float32), 8, axis=0), 8, axis=1)
    depth = np.full(color.shape[:2], depth_m, np.float32)
    lens = lens_blurring(coc_px, color.shape[1])
    smaller = render_plate(renderer, color, depth, lens)
    monkeypatch.setattr(layer_plan, "REDUCTIONS", ())
    whole = render_plate(renderer, color, depth, lens)
    assert not np.array_equal(smaller, whole)
    np.testing.assert_allclose(smaller, whole, atol=0.03)  # beyond the border goes a mean of pixels
    inside = slice(20, -20), slice(20, -20)
    np.testing.assert_allclose(smaller[inside], whole[inside], atol=0.012)
    assert smaller.mean() == pytest.approx(whole.mean(), rel=1e-3)


def test_reduced_layer_keeps_moments_of_blurred_square(ctx, renderer, monkeypatch):
    color = np.full((257, 257, 3), 0.02, np.float32)
    color[124:133, 124:133] = 1.0
    depth = np.full((257, 257), FAR_M, np.float32)
    lens = lens_blurring(60.0, 257)
    smaller = moments(render_plate(renderer, color, depth, lens) - 0.02)
    monkeypatch.setattr(layer_plan, "REDUCTIONS", ())
    whole = moments(render_plate(renderer, color, depth, lens) - 0.02)
    np.testing.assert_allclose(smaller, whole, rtol=0.01)


def test_change_of_layer_reduction_in_a_pull_is_invisible(ctx, renderer):
    """Open the lens in small steps past a coc of 53 px, from which on the far layer is halved."""
    color, depth = room(480, 270)
    renderer.load(plate_of(color, depth))
    lenses = [Lens(50.0, f_stop, 1.0, 36.0) for f_stop in np.linspace(0.68, 0.56, 11)]
    reductions = [
        [plan.reduction for plan in layer_plans_through(renderer, lens)] for lens in lenses
    ]
    assert reductions[0] != reductions[-1]
    frames = [
        np.clip(renderer.pixels(Shot(lens, DefocusSettings()))[..., :3], 0, 1) for lens in lenses
    ]
    changes = np.abs(np.diff(frames, axis=0))
    steps = changes.mean(axis=(1, 2, 3))
    assert steps.max() < 2.0 * steps.mean()
    assert np.quantile(changes, 0.999, axis=(1, 2, 3)).max() < 2 / 255


def test_picture_does_not_jump_where_layer_reduction_changes(ctx, renderer):
    """Check the steps around each change of the mixed sizes: it is at most 1.5 of its neighbors."""
    renderer.load(plate_of(*room(480, 270)))
    lenses = [Lens(50.0, f_stop, 1.0, 36.0) for f_stop in np.linspace(0.68, 0.57, 551)]
    sizes = [
        [
            size.reduction
            for plan in layer_plans_through(renderer, lens)
            for size in plan.sized_plans
        ]
        for lens in lenses
    ]
    changes = [n for n in range(1, len(lenses)) if sizes[n] != sizes[n - 1]]
    assert [sizes[n] for n in changes] == [[1, 2, 1, 1], [2, 1, 1]]
    for n in changes:
        shots = [Shot(lens, DefocusSettings()) for lens in lenses[n - 2 : n + 2]]
        frames = [renderer.pixels(shot)[..., :3].copy() for shot in shots]
        before, across, after = np.abs(np.diff(frames, axis=0)).mean(axis=(1, 2, 3))
        assert across < 1.5 * max(before, after)


def layer_plans_through(renderer: FrameRenderer, lens: Lens) -> list[LayerPlan]:
    optics = renderer.optics(Shot(lens, DefocusSettings()))
    cuts = layer_cuts(optics.occupied_px, optics.gaps_px, LAYERS_MAX)
    return layer_plans(cuts, optics, (480, 270))
