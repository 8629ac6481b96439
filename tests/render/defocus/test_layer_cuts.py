"""Layer cuts: each coc belongs to one layer, no layer is empty, and cuts do not jump."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.render.defocus.layer_cuts import FIRST_CUT_PX, FIRST_SOFTNESS_PX, layer_cuts
from support.layers import LADDER_PX, ladder_of, membership

COCS = st.lists(st.floats(-300, 300), min_size=1, max_size=40).map(lambda v: np.sort(np.array(v)))


@given(COCS, st.integers(1, 7))
def test_layers_cover_every_circle_of_confusion_once(coc: np.ndarray, layers_max: int) -> None:
    layers = ladder_of(coc, layers_max)
    assert 1 <= len(layers) <= layers_max
    np.testing.assert_allclose(sum(membership(layer, coc) for layer in layers), 1.0, atol=1e-9)


@given(COCS)
def test_layers_are_ordered_from_far_to_near(coc: np.ndarray) -> None:
    layers = ladder_of(coc, 7)
    assert layers[0].is_farthest
    assert [layer.near.at_px for layer in layers] == sorted(
        (layer.near.at_px for layer in layers), reverse=True
    )


def test_single_depth_is_one_layer() -> None:
    for coc in (-200.0, -2.0, 0.0, 5.0, 200.0):
        assert len(ladder_of(np.array([coc, coc]), 7)) == 1


@pytest.mark.parametrize("layers_max", range(2, 7))
def test_few_layers_still_split_foreground_from_sharp_pixels(layers_max: int) -> None:
    """Sharp pixels never share a layer with those in front of them, and all layers are used."""
    layers = ladder_of(np.linspace(-100, 0.5, 400), layers_max)
    limits = [layer.near.at_px for layer in layers[:-1]]
    assert len(layers) == layers_max and limits[0] == FIRST_CUT_PX
    assert limits == sorted(limits, reverse=True)


def test_three_layers_have_far_cut() -> None:
    limits = [layer.near.at_px for layer in ladder_of(np.linspace(-100, 50, 400), 3)]
    assert limits[:2] == pytest.approx([50 / 3, FIRST_CUT_PX])


@pytest.mark.parametrize("start", [FIRST_CUT_PX + FIRST_SOFTNESS_PX, *LADDER_PX[:, 1]])
def test_new_cut_starts_with_nearly_empty_layer(start: float) -> None:
    """The layer that a nearer coc adds holds less than 1e-4 of the pixels at that coc."""
    before = ladder_of(np.linspace(start + 1e-3, 0, 200), 7)
    after = ladder_of(np.linspace(start - 1e-3, 0, 200), 7)
    assert len(after) == len(before) + 1
    assert membership(after[-1], np.array([start - 1e-3]))[0] < 1e-4


@given(COCS, st.integers(1, 7), st.floats(0.05, 1.0))
def test_layer_cuts_scale_with_proxy(coc, layers_max, proxy) -> None:
    whole, small = ladder_of(coc, layers_max), ladder_of(coc * proxy, layers_max, proxy)
    assert len(whole) == len(small)
    for layer, small_layer in zip(whole, small, strict=True):
        assert (layer.is_farthest, layer.is_nearest) == (
            small_layer.is_farthest,
            small_layer.is_nearest,
        )
        for cut, scaled in ((layer.near, small_layer.near), (layer.far, small_layer.far)):
            if abs(cut.at_px) < 1e9:
                assert scaled.at_px == pytest.approx(cut.at_px * proxy)


@given(COCS, st.integers(1, 7), st.floats(0.05, 1.0))
def test_layers_from_first_near_cut_on_are_before_focus(
    coc: np.ndarray, layers_max: int, proxy: float
) -> None:
    """The first near cut itself counts: it is where sharp pixels end and blurred ones begin."""
    farthest, *others = ladder_of(coc * proxy, layers_max, proxy)
    for layer in others:
        assert layer.is_before_focus == (layer.far.at_px < 0)
    if others:
        assert not farthest.is_before_focus


def test_layer_next_to_sharp_layer_is_before_focus() -> None:
    layers = ladder_of(np.linspace(-100, 0.5, 400), 6)
    assert layers[1].far.at_px == FIRST_CUT_PX
    assert [layer.is_before_focus for layer in layers] == [False] + [True] * 5


def test_cuts_use_nearest_gaps_if_there_are_too_many() -> None:
    """Cuts stay where they are while the focus moves away and more gaps come before it."""
    for nearest_px in (-90.0, -70.0):
        limits = [it.near.at_px for it in ladder_of(np.linspace(nearest_px, 0, 400), 3)[:-1]]
        assert limits == [FIRST_CUT_PX, LADDER_PX[0].mean()]


@pytest.mark.parametrize("gap_px", [-1.7, -1.45, -1.0, 3.0])
def test_gap_coming_into_focus_does_not_move_first_cut(gap_px: float) -> None:
    layers = layer_cuts(np.linspace(-90.0, 0, 400), np.array([[gap_px - 0.1, gap_px + 0.1]]), 7)
    assert len(layers) == 2 + (gap_px == -1.7)
    coc = np.linspace(-3.0, 0.0, 200)
    np.testing.assert_allclose(sum(membership(layer, coc) for layer in layers), 1.0, atol=1e-9)
