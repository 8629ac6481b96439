"""Proxy of a plate without lists: near and far surfaces of each pixel at silhouettes are listed."""

import numpy as np
import pytest

from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.fragments import FragmentLists
from heatlens.render.defocus.listed_fragments import FragmentBuffers
from heatlens.render.defocus.reduced_plate import (
    FRAGMENT_BYTES,
    ProxyListMemory,
    proxy_list_capacity,
)
from heatlens.render.gpu.textures import download, new_texture, upload
from support.plates import FAR_M, FOCUS_M, NEAR_M, Image, lens_blurring, plate_of

HEIGHT, WIDTH, STEP = 48, 72, 4
SMALL = WIDTH // STEP, HEIGHT // STEP


@pytest.fixture
def passes(ctx, renderer):
    return renderer._passes


def reduce_and_list(
    ctx, passes, color: Image, depth_m: Image
) -> tuple[Image, Image, FragmentLists]:
    """Return colour, depth and lists at a quarter of the size."""
    whole = [new_texture(ctx, (WIDTH, HEIGHT), n) for n in (4, 1)]
    for texture, pixels in zip(whole, (color, depth_m), strict=True):
        upload(texture, pixels)
    small = [new_texture(ctx, SMALL, 4), new_texture(ctx, SMALL, 1)]
    small.append(new_texture(ctx, SMALL, 4, "f2"))
    passes.proxy.run(*whole, 1.0, *small)
    capacity, pixels = proxy_list_capacity(ctx, None, SMALL), SMALL[0] * SMALL[1]
    buffers = ctx.buffer(reserve=4 * (pixels + 1)), ctx.buffer(reserve=FRAGMENT_BYTES * capacity)
    list_memory = ProxyListMemory(
        lists=FragmentBuffers(*buffers, SMALL, True), capacity=capacity, total=ctx.buffer(reserve=4)
    )
    passes.proxy_lists.list_silhouettes(*whole, small[2], list_memory, small[1])
    starts = np.frombuffer(buffers[0].read(), np.uint32)
    words = np.frombuffer(buffers[1].read(), np.uint32).reshape(-1, 3)[: starts[-1] >> 1]
    return download(small[0]), download(small[1]), FragmentLists(starts, words)


def two_surfaces(rng: np.random.Generator, alpha: Image) -> tuple[Image, Image]:
    """Return a premultiplied picture with a near thing in one pixel of twelve, and its depth."""
    light = rng.random((HEIGHT, WIDTH, 3), np.float32)
    depth_m = np.where(rng.random((HEIGHT, WIDTH)) < 1 / 12, NEAR_M, FAR_M).astype(np.float32)
    return np.concatenate([light * alpha[..., None], alpha[..., None]], axis=2), depth_m


@pytest.mark.parametrize("has_alpha", [False, True])
def test_silhouette_lists_composite_to_mean_color(ctx, passes, rng, has_alpha):
    shape = HEIGHT, WIDTH
    alpha = rng.random(shape, np.float32) if has_alpha else np.ones(shape, np.float32)
    color, depth_m = two_surfaces(rng, alpha)
    mean, near_m, lists = reduce_and_list(ctx, passes, color, depth_m)
    first = lists.begins[:-1]
    is_listed = np.diff(lists.begins) == 2
    assert 0.1 < is_listed.mean() < 0.9
    first, cover = first[is_listed], lists.coverage.astype(np.float32)
    light = np.concatenate([lists.color, np.ones((len(lists.color), 1))], axis=1)
    composite = cover[first, None] * light[first]
    composite += ((1 - cover[first]) * cover[first + 1])[:, None] * light[first + 1]
    np.testing.assert_allclose(composite, mean.reshape(-1, 4)[is_listed], atol=3e-3)
    np.testing.assert_allclose(1 / lists.dioptres[first], NEAR_M, rtol=1e-5)
    np.testing.assert_allclose(1 / lists.dioptres[first + 1], FAR_M, rtol=1e-5)
    np.testing.assert_allclose(near_m.ravel()[is_listed], NEAR_M, rtol=1e-5)


def test_silhouette_lists_skip_slopes_and_highlights(ctx, passes):
    """Check that a receding floor has no silhouettes, nor a pixel whose highlight outshines it."""
    color = np.full((HEIGHT, WIDTH, 4), 0.1, np.float32)
    color[..., 3] = 1.0
    rows = np.repeat(np.linspace(1.0, 0.25, HEIGHT, dtype=np.float32)[:, None], WIDTH, axis=1)
    assert not reduce_and_list(ctx, passes, color, 1 / rows)[2].starts.any()
    depth_m = np.full((HEIGHT, WIDTH), FAR_M, np.float32)
    depth_m[9, 13] = FOCUS_M
    assert reduce_and_list(ctx, passes, color, depth_m)[2].starts.max() == 4
    color[9, 13, :3] = 80.0
    assert not reduce_and_list(ctx, passes, color, depth_m)[2].starts.any()


@pytest.mark.parametrize("proxy", [1.0, 0.25])
def test_thin_blurred_wires_dim_wall_evenly(renderer, proxy):
    """Check that thin blurred wires before a wall in focus dim it evenly, at both proxy sizes."""
    height, width, apart = 96, 144, 8
    color = np.ones((height, width, 4), np.float32)
    depth_m = np.full((height, width), FOCUS_M, np.float32)
    color[:, ::apart, :3], depth_m[:, ::apart] = 0.0, NEAR_M
    renderer.load(plate_of(color, depth_m))
    lens = lens_blurring(24.0, width)
    picture = renderer.pixels(Shot(lens, DefocusSettings(proxy=proxy)))[..., 0]
    edge = round(24 * proxy)
    inner = picture[edge:-edge, edge:-edge]
    assert inner.std() < 0.03
    assert abs(inner.mean() - (1 - 1 / apart)) < 0.03
