"""Layers of much blur are worked on smaller: when, and how little of it is to be seen."""

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


def plans_of(coc: np.ndarray, size: tuple[int, int] = LARGE) -> list[LayerPlan]:
    optics = Optics(None, coc)
    return layer_plans(ladder_of(coc), optics, size)


@given(COCS)
def test_the_coc_of_a_smaller_layer_stays_large_enough(coc: np.ndarray) -> None:
    for plan in plans_of(coc):
        low, high = plan.ends_px
        held = np.abs(coc[(coc > low) & (coc < high)])
        assert plan.reduction == 1 or held.min() >= plan.reduction * LEAST_REDUCED_PX


@given(COCS, st.floats(-500, 500))
def test_near_layers_keep_their_size_whatever_else_comes(coc: np.ndarray, other: float) -> None:
    """So that in a pull none changes its size because something comes into another layer."""
    before, after = (
        {plan.ends_px: plan.reduction for plan in plans_of(np.sort(cocs)) if plan.ends_px[1] < 0}
        for cocs in (coc, np.append(coc, other))
    )
    for ends in before.keys() & after.keys():
        assert before[ends] == after[ends]


@given(COCS, st.integers(1, 200), st.integers(1, 200))
def test_a_smaller_layer_covers_the_picture_and_is_not_tiny(coc, width, height) -> None:
    for plan in plans_of(coc, (width, height)):
        across, down = plan.size((width, height))
        assert 0 <= across * plan.reduction - width < plan.reduction
        assert 0 <= down * plan.reduction - height < plan.reduction
        assert plan.reduction == 1 or min(width, height) >= LEAST_REDUCED_SIDE * plan.reduction


def test_resampling_counts_as_the_blur_that_it_is() -> None:
    """Measured on points that a box reduces and linear interpolation enlarges again."""
    for reduction in (2, 4, 8):
        variances = []
        for place in range(8 * reduction, 9 * reduction):
            line = np.zeros(17 * reduction)
            line[place] = 1.0
            small = line.reshape(-1, reduction).mean(axis=1)
            centres = reduction * (np.arange(len(small)) + 0.5) - 0.5
            large = np.interp(np.arange(len(line)), centres, small)
            x = np.arange(len(line)) - place
            variances.append((large * x**2).sum() / large.sum())
        plan = LayerPlan(ladder_of(np.array([200.0]))[0], reduction, 200.0, 200.0)
        expected = plan.resampled_px_2 / 16 * reduction**2
        assert np.mean(variances) == pytest.approx(expected, rel=0.35, abs=0.1)


def rendered(renderer: FrameRenderer, color: Image, depth: Image, lens: Lens) -> Image:
    renderer.load(plate_of(color, depth))
    return renderer.pixels(Shot(lens, DefocusSettings()))[..., :3]


@pytest.mark.parametrize(
    ("coc_px", "depth_m"),
    [(27.0, NEAR_M), (55.0, NEAR_M), (120.0, NEAR_M), (61.0, FAR_M), (120.0, FAR_M)],
)
def test_a_smaller_layer_blurs_as_the_whole_one_does(
    ctx, renderer, rng, monkeypatch, coc_px, depth_m
):
    """A wall of random squares: the same within three steps of a screen, and all of its light."""
    color = np.repeat(np.repeat(rng.random((64, 80, 3), np.float32), 8, axis=0), 8, axis=1)
    depth = np.full(color.shape[:2], depth_m, np.float32)
    lens = lens_blurring(coc_px, color.shape[1])
    smaller = rendered(renderer, color, depth, lens)
    monkeypatch.setattr(layer_plan, "REDUCTIONS", ())
    whole = rendered(renderer, color, depth, lens)
    assert not np.array_equal(smaller, whole)
    np.testing.assert_allclose(smaller, whole, atol=0.03)  # beyond the border goes a mean of pixels
    inside = slice(20, -20), slice(20, -20)
    np.testing.assert_allclose(smaller[inside], whole[inside], atol=0.012)
    assert smaller.mean() == pytest.approx(whole.mean(), rel=1e-3)


def test_a_small_square_becomes_the_same_disc(ctx, renderer, monkeypatch):
    color = np.full((257, 257, 3), 0.02, np.float32)
    color[124:133, 124:133] = 1.0
    depth = np.full((257, 257), FAR_M, np.float32)
    lens = lens_blurring(60.0, 257)
    smaller = moments(rendered(renderer, color, depth, lens) - 0.02)
    monkeypatch.setattr(layer_plan, "REDUCTIONS", ())
    whole = moments(rendered(renderer, color, depth, lens) - 0.02)
    np.testing.assert_allclose(smaller, whole, rtol=0.01)


def test_a_layer_that_changes_its_size_in_a_pull_does_not_show(ctx, renderer):
    """The far layer is halved from a coc of 53 px on; the lens opens by a hundredth of a stop."""
    color, depth = room(480, 270)
    renderer.load(plate_of(color, depth))
    lenses = [Lens(50.0, f_stop, 1.0, 36.0) for f_stop in np.linspace(0.68, 0.56, 11)]
    reductions = [[plan.reduction for plan in plans_through(renderer, lens)] for lens in lenses]
    assert reductions[0] != reductions[-1]
    frames = [
        np.clip(renderer.pixels(Shot(lens, DefocusSettings()))[..., :3], 0, 1) for lens in lenses
    ]
    changes = np.abs(np.diff(frames, axis=0))
    steps = changes.mean(axis=(1, 2, 3))
    assert steps.max() < 2.0 * steps.mean()
    assert np.quantile(changes, 0.999, axis=(1, 2, 3)).max() < 2 / 255


def test_a_layer_changes_its_size_without_a_jump(ctx, renderer):
    """Where another size begins or ends to count, the picture changes as at the steps around it."""
    renderer.load(plate_of(*room(480, 270)))
    lenses = [Lens(50.0, f_stop, 1.0, 36.0) for f_stop in np.linspace(0.68, 0.57, 551)]
    sizes = [
        [size.reduction for plan in plans_through(renderer, lens) for size in plan.sizes]
        for lens in lenses
    ]
    changes = [n for n in range(1, len(lenses)) if sizes[n] != sizes[n - 1]]
    assert [sizes[n] for n in changes] == [[1, 2, 1, 1], [2, 1, 1]]
    for n in changes:
        shots = [Shot(lens, DefocusSettings()) for lens in lenses[n - 2 : n + 2]]
        frames = [renderer.pixels(shot)[..., :3].copy() for shot in shots]
        before, across, after = np.abs(np.diff(frames, axis=0)).mean(axis=(1, 2, 3))
        assert across < 1.5 * max(before, after)


def plans_through(renderer: FrameRenderer, lens: Lens) -> list[LayerPlan]:
    optics = renderer.optics(Shot(lens, DefocusSettings()))
    cuts = layer_cuts(optics.occupied_px, optics.gaps_px, LAYERS_MAX)
    return layer_plans(cuts, optics, (480, 270))
