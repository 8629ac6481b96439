"""Fragment lists of a proxy picture: coverage is averaged and light is kept."""

from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.model.shot.settings import Bokeh, DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.fragments import FragmentLists
from heatlens.media.plate.plate import Plate
from heatlens.render.defocus import reduced_plate
from heatlens.render.defocus.listed_fragments import FragmentBuffers
from heatlens.render.defocus.plate_passes import proxy_size
from heatlens.render.defocus.reduced_plate import (
    FRAGMENT_BYTES,
    ProxyListMemory,
    proxy_list_capacity,
)
from heatlens.render.gpu.textures import download, new_texture, upload
from support.alpha_plates import Layer, plate_of_layers
from support.plates import FAR_M, FOCUS_M, NEAR_M, Image, lens_blurring, plate_of, room

HEIGHT, WIDTH = 24, 36


def everywhere(value: float) -> Image:
    return np.full((HEIGHT, WIDTH), value, np.float32)


@pytest.fixture
def passes(ctx, renderer):
    return renderer._passes


def reduce_plate(ctx, passes, plate: Plate, proxy: float) -> tuple[Image, Image, FragmentLists]:
    """Return color, depth and fragment lists of `plate` at the scale `proxy`."""
    lists, size = plate.fragments, (WIDTH, HEIGHT)
    color, depth = new_texture(ctx, size, 4), new_texture(ctx, size, 1)
    upload(color, plate.color)
    upload(depth, plate.depth_m)
    small = proxy_size(size, proxy)
    out_color, out_depth = new_texture(ctx, small, 4), new_texture(ctx, small, 1)
    passes.proxy.run(color, depth, 1.0, out_color, out_depth)
    starts, words = ctx.buffer(lists.starts), ctx.buffer(lists.words)
    whole = FragmentBuffers(starts, words, size, lists.is_measured)
    capacity = proxy_list_capacity(ctx, whole, small)
    pixels = small[0] * small[1]
    buffers = ctx.buffer(reserve=4 * (pixels + 1)), ctx.buffer(reserve=FRAGMENT_BYTES * capacity)
    fragment_buffers = FragmentBuffers(*buffers, small, lists.is_measured)
    passes.proxy_lists.merge(
        color,
        depth,
        whole,
        ProxyListMemory(lists=fragment_buffers, capacity=capacity, total=ctx.buffer(reserve=4)),
        out_depth,
    )
    made = np.frombuffer(buffers[0].read(), np.uint32)
    found = np.frombuffer(buffers[1].read(), np.uint32).reshape(-1, 3)[: made[-1] >> 1]
    return download(out_color), download(out_depth), FragmentLists(made, found)


def flatten_lists(color: Image, lists: FragmentLists) -> Image:
    """Return premultiplied RGBA (P, 4): composited lists, or `color` where a pixel has no list."""
    out = color.reshape(-1, 4).copy()
    cover, light = lists.coverage.astype(np.float32), lists.color.astype(np.float32)
    for pixel in np.flatnonzero(lists.has_front):
        composite, transmittance = np.zeros(4), 1.0
        for i in range(*lists.begins[pixel : pixel + 2]):
            composite += transmittance * cover[i] * np.append(light[i], 1.0)
            transmittance *= 1 - cover[i]
        out[pixel] = composite
    return out


def many_surfaces(rng: np.random.Generator) -> list[Layer]:
    def cover() -> Image:
        return rng.choice(np.float32([0, 0.25, 0.5, 1]), (HEIGHT, WIDTH), p=[0.4, 0.2, 0.2, 0.2])

    light = [rng.random((HEIGHT, WIDTH), np.float32) for _ in range(5)]
    return [(light[k], cover(), 1.0 + 0.6 * k) for k in range(5)]


@pytest.mark.parametrize("proxy", [0.5, 0.25, 0.4])
def test_proxy_lists_composite_to_mean_color(ctx, passes, rng, proxy):
    plate = plate_of_layers(many_surfaces(rng), has_alpha=True)
    color, _, lists = reduce_plate(ctx, passes, plate, proxy)
    np.testing.assert_allclose(flatten_lists(color, lists), color.reshape(-1, 4), atol=3e-3)
    assert lists.has_front.mean() > 0.9
    assert np.diff(lists.begins).max() <= 8  # GROUPS_MOST of proxy_lists.comp.glsl


def test_proxy_lists_average_coverage_over_footprint(ctx, passes):
    """Put a card over half of each footprint before a wall: both are listed, the card with 0.5."""
    card = everywhere(0.0)
    card[:, 1::2] = 1.0
    plate = plate_of_layers([(0.8, card, NEAR_M), (0.2, everywhere(1.0), FAR_M)], has_alpha=False)
    _, depth, lists = reduce_plate(ctx, passes, plate, 0.5)
    assert (np.diff(lists.begins) == 2).all() and lists.has_front.all()
    np.testing.assert_allclose(
        lists.coverage.reshape(-1, 2), [[0.5, 1.0]] * (len(lists.starts) - 1)
    )
    np.testing.assert_allclose(lists.color[:, 0].reshape(-1, 2)[0], [0.8, 0.2], rtol=1e-3)
    np.testing.assert_allclose(depth, NEAR_M, rtol=1e-6)


def test_proxy_lists_without_coverage_keep_hidden_wall(ctx, passes):
    """Check lists without measured coverage: the proxy is flat, only the wall is listed behind."""
    near = (0.5, everywhere(1.0), NEAR_M)
    twin = (0.5, everywhere(1.0), 1.01 * NEAR_M)  # so close behind that it is the same surface
    layers = [near, twin, (0.3, everywhere(1.0), FAR_M)]
    plate = plate_of_layers(layers, has_alpha=False, is_measured=False)
    _, depth, lists = reduce_plate(ctx, passes, plate, 0.5)
    assert not (lists.starts & 1).any() and (np.diff(lists.begins) == 1).all()
    np.testing.assert_allclose(lists.coverage, 1.0)
    np.testing.assert_allclose(lists.dioptres, 1 / FAR_M, rtol=1e-6)
    assert (depth == np.float32(NEAR_M)).all()


def test_proxy_lists_put_wall_behind_wire_not_room(ctx, passes):
    """Put a wire before a wall with a room behind it: behind the wire only the wall comes first."""
    wire = everywhere(0.0)
    wire[:, 1::2] = 1.0  # where a footprint's depth is sampled
    layers = [(0.5, wire, NEAR_M), (0.3, everywhere(1.0), 3.0), (0.9, everywhere(1.0), FAR_M)]
    plate = plate_of_layers(layers, has_alpha=False, is_measured=False)
    _, depth, lists = reduce_plate(ctx, passes, plate, 0.5)
    assert (depth == np.float32(NEAR_M)).all()
    first = lists.begins[:-1]
    np.testing.assert_allclose(lists.dioptres[first], 1 / 3.0, rtol=1e-6)
    np.testing.assert_allclose(lists.coverage[first], 1.0)


def render_through_lens(renderer, plate: Plate, coc_px: float, **settings: object) -> Image:
    renderer.load(plate)
    lens = lens_blurring(coc_px, plate.display_window.width)
    return renderer.pixels(Shot(lens, DefocusSettings(**settings)))


@pytest.mark.parametrize("is_measured", [False, True])
def test_proxy_with_empty_lists_equals_flat_picture(ctx, renderer, is_measured):
    """Check that empty lists change nothing in a picture without silhouettes."""
    height, width = 48, 72
    color, _ = room(width, height)
    flat = plate_of(color, np.full((height, width), FAR_M, np.float32))
    lists = FragmentLists(
        np.zeros(height * width + 1, np.uint32), np.zeros((1, 3), np.uint32), is_measured
    )
    listed = replace(flat, fragments=lists)
    pictures = [render_through_lens(renderer, plate, 12.0, proxy=0.5) for plate in (flat, listed)]
    assert np.array_equal(*pictures)


@pytest.mark.parametrize("proxy", [1.0, 0.5, 0.25])
def test_uniform_color_with_lists_stays_uniform(ctx, renderer, rng, proxy):
    covers = rng.random((5, HEIGHT, WIDTH), np.float32) ** 2
    covers[:, ::3, ::2] = 1.0  # hides what is behind it
    layers = [(0.4, covers[k], 1.0 + 0.6 * k) for k in range(5)]
    plate = plate_of_layers([*layers, (0.4, everywhere(1.0), FAR_M)], has_alpha=False)
    picture = render_through_lens(renderer, plate, 8.0, proxy=proxy, bokeh=Bokeh.HEAT)
    np.testing.assert_allclose(picture[..., :3], 0.4, rtol=5e-3)


def test_proxy_pass_keeps_depth_of_small_lamp(ctx, passes):
    """Put a lamp beside the depth sample: the proxy pixel has its depth, a dim pixel the wall's."""
    color, depth = np.full((HEIGHT, WIDTH, 4), 0.1, np.float32), everywhere(FAR_M)
    color[..., 3] = 1.0
    for lamp, expected in ((0.1, FAR_M), (50.0, FOCUS_M)):
        color[8, 12, :3], depth[8, 12] = lamp, FOCUS_M
        plate = plate_of(color, depth)
        textures = [new_texture(ctx, (WIDTH, HEIGHT), k) for k in (4, 1)]
        upload(textures[0], plate.color)
        upload(textures[1], plate.depth_m)
        out = [new_texture(ctx, (WIDTH // 4, HEIGHT // 4), k) for k in (4, 1)]
        passes.proxy.run(*textures, 1.0, *out)
        found = download(out[1])
        assert found[2, 3] == np.float32(expected)
        assert (np.delete(found.ravel(), 2 * (WIDTH // 4) + 3) == np.float32(FAR_M)).all()


def test_proxy_lists_summed_in_parts_are_the_same(ctx, passes, rng, monkeypatch):
    layers = [(0.2 + k, (rng.random((HEIGHT, WIDTH)) < 0.5) * 0.6, 2.0 + k) for k in range(3)]
    plate = plate_of_layers(layers, has_alpha=True)
    *_, expected = reduce_plate(ctx, passes, plate, 0.7)
    monkeypatch.setattr(reduced_plate, "_PIXELS_PER_SUM", 37)
    *_, lists_in_parts = reduce_plate(ctx, passes, plate, 0.7)
    np.testing.assert_array_equal(lists_in_parts.starts, expected.starts)
    np.testing.assert_array_equal(lists_in_parts.words, expected.words)
