"""Compare lists of pixels made of stacked images with those of a plain loop over the pixels."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.media.plate.deep.stacked import Surface, farthest_m, stack_surfaces
from heatlens.media.plate.fragments import SAME_DEPTH, FragmentLists

COVERS = [0.0, 0.25, 0.5, 1.0]
Fragment = tuple[float, float, float]  # metres, coverage, red
DEPTHS = [1.0, 2.0, 2.5, 7.0, np.inf]


@st.composite
def stacks(draw) -> list[Surface]:
    """Return one to four surfaces of 2 x 3 pixels; colours are exact in half."""
    surfaces = []
    for _ in range(draw(st.integers(1, 4))):
        cover = draw(st.lists(st.sampled_from(COVERS), min_size=6, max_size=6))
        depth = draw(st.lists(st.sampled_from(DEPTHS), min_size=6, max_size=6))
        light = draw(st.lists(st.integers(0, 16), min_size=6, max_size=6))
        rgba = np.ones((6, 4), np.float32) * np.array(light, np.float32)[:, None] / 4
        rgba *= np.array(cover, np.float32)[:, None]
        rgba[:, 3] = cover
        surfaces.append(Surface(rgba.reshape(2, 3, 4), np.array(depth, np.float32).reshape(2, 3)))
    return surfaces


def fragments_of(surfaces: list[Surface], pixel: int) -> list[Fragment]:
    """Return (distance, coverage, red) from near to far, one fragment for each distance."""
    unsorted = []
    for surface in surfaces:
        *rgb, cover = surface.color.reshape(-1, 4)[pixel]
        if cover > 0:
            unsorted.append((float(surface.depth_m.ravel()[pixel]), float(cover), float(rgb[0])))
    merged: list[Fragment] = []
    for depth, cover, red in sorted(unsorted):
        if merged and merged[-1][0] == depth:
            _, before, before_red = merged.pop()
            cover, red = before + (1 - before) * cover, before_red + (1 - before) * red
        merged.append((depth, cover, red))
    return [(depth, cover, red / cover) for depth, cover, red in merged]


def list_of(lists: FragmentLists | None, pixel: int) -> tuple[bool, list[Fragment]]:
    if lists is None:
        return False, []
    first, end = lists.begins[pixel : pixel + 2]
    with np.errstate(divide="ignore"):
        depth = 1 / lists.dioptres[first:end]
    rows = zip(depth, lists.coverage[first:end], lists.color[first:end, 0], strict=True)
    return bool(lists.has_front[pixel]), [tuple(map(float, row)) for row in rows]


@given(stacks())
def test_stacked_lists_match_loop_over_pixels(surfaces):
    stack = stack_surfaces(surfaces)
    expected_lists = [fragments_of(surfaces, pixel) for pixel in range(6)]
    has_lists = any(len(fragments) > 1 for fragments in expected_lists)
    for pixel, expected in enumerate(expected_lists):
        light, left = np.zeros(4), 1.0
        for _, cover, red in expected:
            light += left * cover * np.array([red, red, red, 1.0])
            left *= 1 - cover
        np.testing.assert_allclose(stack.color.reshape(-1, 4)[pixel], light, atol=1e-6)
        nearest = expected[0][0] if expected else np.inf
        assert stack.depth_m.ravel()[pixel] == nearest
        has_front, listed = list_of(stack.lists, pixel)
        is_opaque = bool(expected) and expected[0][1] == 1.0
        assert has_front == (has_lists and bool(expected) and not is_opaque)
        behind = expected if has_front else expected[1:] if is_opaque else []
        assert len(listed) == len(behind)
        np.testing.assert_allclose(listed, behind, rtol=1e-3)  # colours are halfs


@given(stacks(), st.randoms(use_true_random=False))
def test_stacked_does_not_depend_on_order_of_surfaces(surfaces, random):
    stack = stack_surfaces(surfaces)
    random.shuffle(surfaces)
    shuffled_stack = stack_surfaces(surfaces)
    assert np.array_equal(stack.color, shuffled_stack.color)
    assert np.array_equal(stack.depth_m, shuffled_stack.depth_m)
    assert (stack.lists is None) == (shuffled_stack.lists is None)
    if stack.lists is not None and shuffled_stack.lists is not None:
        assert np.array_equal(stack.lists.starts, shuffled_stack.lists.starts)
        assert np.array_equal(stack.lists.words, shuffled_stack.lists.words)


@pytest.mark.parametrize("second_m", [2.0, 2.0 * (1 + 0.5 * SAME_DEPTH)])
def test_stacked_merges_repeated_opaque_surface(second_m):
    color = np.ones((1, 1, 4), np.float32)
    twice = [Surface(color, np.full((1, 1), z, np.float32)) for z in (2.0, second_m)]
    assert stack_surfaces(twice).lists is None


@given(stacks())
def test_farthest_m_is_last_of_list_or_visible_depth(surfaces):
    stack = stack_surfaces(surfaces)
    depths = farthest_m(Surface(stack.color, stack.depth_m, stack.lists)).ravel()
    expected = stack.depth_m.copy().ravel()
    for pixel in range(6 if stack.lists is not None else 0):
        begin, end = stack.lists.begins[pixel : pixel + 2]
        if begin < end:
            last = stack.lists.dioptres[end - 1]
            expected[pixel] = np.float32(1.0) / last if last > 0 else np.inf
    np.testing.assert_array_equal(depths, expected)
    assert np.all(depths >= stack.depth_m.ravel() * (1 - 1e-6))
