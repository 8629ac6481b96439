"""PicturePass against arrays: position, clip, compositing, nearest and smooth sampling."""

import numpy as np
import pytest

from heatlens.core.model.boxes import Box
from heatlens.core.model.focus.coc import CocLine
from heatlens.render.display.picture_pass import (
    TILE_PX,
    Detail,
    EnlargePass,
    PicturePass,
    PlacedPicture,
)
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Sampling, Texture
from support.rounding import tolerance_for

SCREEN = 64, 40
ALL = Box(0, 0, *SCREEN)


@pytest.fixture(scope="module")
def pictures(session_context) -> PicturePass:
    return PicturePass(session_context)


def texture_of(ctx: Device, pixels: np.ndarray) -> Texture:
    texture = ctx.texture(pixels.shape[1::-1], 4, np.ascontiguousarray(pixels).tobytes())
    texture.repeats = False
    return texture


def placed_picture(
    texture: Texture, first=(0, 0), last=SCREEN, clip=ALL, is_nearest=True, **options
) -> PlacedPicture:
    return PlacedPicture(texture, first, last, clip, is_nearest, **{"is_opaque": True} | options)


def paint(ctx: Device, pictures: PicturePass, *placed: PlacedPicture, size=SCREEN) -> np.ndarray:
    """Return (H, W, 4) bytes drawn over a screen of (10, 20, 30, 255), top row first."""
    texture = ctx.texture(size, 4)
    target = ctx.framebuffer([texture])
    target.clear(10 / 255, 20 / 255, 30 / 255, 1.0)
    pictures.run(placed, target, size)
    pixels = np.frombuffer(texture.read(), np.uint8).reshape(size[1], size[0], 4)[::-1]
    ctx.simple_framebuffer((1, 1)).use()
    for resource in (target, texture):
        resource.release()
    return pixels


def noise(rng: np.random.Generator, height: int, width: int, alpha: int = 255) -> np.ndarray:
    pixels = rng.integers(0, 256, (height, width, 4), dtype=np.uint8)
    pixels[..., 3] = alpha
    return pixels


@pytest.mark.parametrize("zoom", [1, 2, 3, 5])
def test_nearest_picture_repeats_pixels_at_whole_zoom(ctx, pictures, rng, zoom):
    pixels = noise(rng, 7, 9)
    last = 4 + 9 * zoom, 3 + 7 * zoom
    placed = placed_picture(texture_of(ctx, pixels), first=(4, 3), last=last)
    found = paint(ctx, pictures, placed)
    expected = pixels.repeat(zoom, axis=0).repeat(zoom, axis=1)
    np.testing.assert_array_equal(found[3 : last[1], 4 : last[0]], expected)
    outside = np.ones(SCREEN[::-1], bool)
    outside[3 : last[1], 4 : last[0]] = False
    assert np.all(found[outside] == (10, 20, 30, 255))


def test_nearest_picture_samples_nearest_pixels_at_any_zoom(ctx, pictures, rng):
    pixels = noise(rng, 7, 9)
    first, zoom = (-3.3, 2.7), 4.6
    last = first[0] + 9 * zoom, first[1] + 7 * zoom
    found = paint(ctx, pictures, placed_picture(texture_of(ctx, pixels), first=first, last=last))
    x, y = np.arange(SCREEN[0]) + 0.5, np.arange(SCREEN[1]) + 0.5
    column, row = (x - first[0]) / zoom, (y - first[1]) / zoom
    inside = ((row >= 0) & (row < 7))[:, None] & ((column >= 0) & (column < 9))
    rows, columns = np.clip(row.astype(int), 0, 6), np.clip(column.astype(int), 0, 8)
    expected = np.where(inside[..., None], pixels[rows][:, columns], (10, 20, 30, 255))
    off = tolerance_for(ctx, 0.0, 0.02)  # pixels whose middle is at an edge between two texels
    assert (found != expected).any(axis=-1).mean() <= off


def test_picture_is_drawn_inside_clip_only(ctx, pictures, rng):
    pixels = noise(rng, 40, 64)
    texture = texture_of(ctx, pixels)
    clip = Box(5, 9, 31, 33)
    found = paint(ctx, pictures, placed_picture(texture, clip=clip))
    expected = np.full_like(pixels, (10, 20, 30, 255))
    expected[9:33, 5:31] = pixels[9:33, 5:31]
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("clip", [Box(5, 5, 5, 20), Box(20, 5, 10, 20), Box(0, 30, 64, 10)])
def test_picture_with_empty_clip_draws_nothing(ctx, pictures, rng, clip):
    texture = texture_of(ctx, noise(rng, 40, 64))
    found = paint(ctx, pictures, placed_picture(texture, clip=clip))
    assert np.all(found == (10, 20, 30, 255))


def test_later_picture_is_composited_by_alpha_on_opaque_screen(ctx, pictures, rng):
    below, above = noise(rng, 40, 64), noise(rng, 40, 64)
    above[..., 3] = rng.integers(0, 256, (40, 64))
    screen = paint(
        ctx,
        pictures,
        placed_picture(texture_of(ctx, below)),
        placed_picture(texture_of(ctx, above), is_opaque=False),
    )
    alpha = above[..., 3:] / 255
    expected = below[..., :3] * (1 - alpha) + above[..., :3] * alpha
    assert abs(screen[..., :3] - expected).max() <= 1
    assert np.all(screen[..., 3] == 255)


def test_opaque_picture_ignores_alpha(ctx, pictures, rng):
    pixels = noise(rng, 40, 64, alpha=0)
    found = paint(ctx, pictures, placed_picture(texture_of(ctx, pixels)))
    np.testing.assert_array_equal(found[..., :3], pixels[..., :3])


def test_mipmapped_picture_drawn_small_is_mean_of_pixels(ctx, pictures, rng):
    """Check mipmapped sampling; ImGui's own sampler would take four pixels of each sixty-four."""
    pixels = noise(rng, 320, 512)
    texture = texture_of(ctx, pixels)
    texture.build_mipmaps()
    texture.sampling = Sampling.MIPMAPPED
    found = paint(ctx, pictures, placed_picture(texture, is_nearest=False))
    means = pixels[..., :3].reshape(40, 8, 64, 8, 3).mean(axis=(1, 3))
    assert abs(found[..., :3] - means).max() <= 4  # three halvings, each of them rounded


def test_linear_picture_interpolates_pixels(ctx, pictures):
    pixels = np.full((1, 2, 4), 255, np.uint8)
    pixels[0, 0, :3] = 0
    texture = texture_of(ctx, pixels)
    texture.sampling = Sampling.LINEAR
    found = paint(ctx, pictures, placed_picture(texture, is_nearest=False))
    x = (np.arange(64) + 0.5) / 32 - 0.5
    np.testing.assert_allclose(found[0, :, 0], 255 * np.clip(x, 0, 1), atol=1)


def test_picture_much_larger_than_screen_keeps_its_pixels(ctx, pictures, rng):
    pixels = noise(rng, 60, 8192)
    zoom, column = 256.0, 8000
    first = (32 - zoom * (column + 0.5), 20 - zoom * 30.5)
    last = first[0] + zoom * 8192, first[1] + zoom * 60
    found = paint(ctx, pictures, placed_picture(texture_of(ctx, pixels), first=first, last=last))
    assert np.all(found[20, 20:44] == pixels[30, column])


def texture_of_depths(ctx: Device, depth: np.ndarray) -> Texture:
    return ctx.texture(depth.shape[::-1], 1, depth.astype("f4").tobytes(), dtype="f4")


@pytest.mark.parametrize("line", [None, CocLine(at_infinity_px=20.0, per_dioptre_px=-40.0)])
def test_preview_gets_detail_of_plate_where_in_focus(ctx, pictures, rng, line):
    """Check that the preview keeps its light and gets the plate's missing detail, only in focus.

    No detail is added where the preview differs, because something nearer spills over the focus.
    """
    height, width = SCREEN[1], SCREEN[0]
    plate, coarse = (rng.integers(100, 130, (height, width, 4)) for _ in range(2))
    preview = coarse + rng.integers(-80, 80, (height, width, 1))
    coc = np.broadcast_to(np.linspace(-8.0, 8.0, width), (height, width))
    depth = coc if line is None else line.per_dioptre_px / (coc - line.at_infinity_px)
    textures = [texture_of(ctx, it.astype(np.uint8)) for it in (plate, coarse, preview)]
    for texture in textures:
        texture.sampling = Sampling.NEAREST
    shares = texture_of(ctx, np.full((height // 5, width // 4, 4), 255, np.uint8))
    depths = texture_of_depths(ctx, depth)
    detail = Detail(textures[0], textures[1], shares, depths, line, texel_px=3.0)
    placed = placed_picture(textures[2], is_nearest=False, detail=detail)
    found = paint(ctx, pictures, placed)[..., :3].astype(float)
    nearer = np.minimum(coc, np.roll(coc, 1, axis=1))  # the pixel to the left, in front or behind
    nearer[:, 0] = coc[:, 0]
    t = np.clip(np.maximum(np.abs(coc), -nearer) / 3.0 - 0.5, 0, 1)
    share = (1 - t * t * (3 - 2 * t))[..., None]
    apart = np.abs(preview - coarse)[..., :3].max(axis=-1, keepdims=True) / 255
    t = np.clip((apart - 0.06) / (0.25 - 0.06), 0, 1)
    share = share * (1 - t * t * (3 - 2 * t))
    expected = preview[..., :3] + share * (plate - coarse)[..., :3]
    np.testing.assert_allclose(found, expected, atol=tolerance_for(ctx, 0.51, 0.6))
    assert share.min() == 0 and share.max() > 0.99


@pytest.mark.parametrize(("coc", "expected"), [(-30.0, 0), (30.0, 50)], ids=["nearer", "farther"])
def test_pixel_in_focus_beside_a_blurred_foreground_gets_no_detail(ctx, pictures, coc, expected):
    """Its plate has some of the foreground's color; beside a background it is a sharp edge."""
    height, width = SCREEN[1], SCREEN[0]
    middle, grey = width // 2, np.full((height, width, 4), 100, np.uint8)
    plate, cocs = grey.copy(), np.zeros((height, width))
    plate[:, middle], cocs[:, middle + 1 :] = 150, coc
    textures = [texture_of(ctx, it) for it in (plate, grey, grey)]
    for texture in textures:
        texture.sampling = Sampling.NEAREST
    depths = texture_of_depths(ctx, cocs)
    detail = Detail(textures[0], textures[1], textures[1], depths, None, texel_px=3.0)
    found = paint(ctx, pictures, placed_picture(textures[2], is_nearest=False, detail=detail))
    np.testing.assert_array_equal(found[:, middle, 0], 100 + expected)


def test_detail_is_drawn_in_the_tiles_that_have_a_share_of_it(ctx, pictures):
    """A tile without any share keeps the preview, also where all of the plate is in focus."""
    height, width = SCREEN[1], SCREEN[0]
    grey, plate = (np.full((height, width, 4), value, np.uint8) for value in (100, 150))
    shares = np.zeros((height // 2, width // 2, 4), np.uint8)
    shares[5, 9, 3] = 1
    textures = [texture_of(ctx, it) for it in (plate, grey, shares)]
    depths = texture_of_depths(ctx, np.zeros((height, width)))
    detail = Detail(*textures, depths, None, texel_px=3.0)
    found = paint(ctx, pictures, placed_picture(texture_of(ctx, grey), detail=detail))
    expected = np.full((height, width), 100)
    expected[: 2 * TILE_PX, 2 * TILE_PX : 4 * TILE_PX] = 150
    np.testing.assert_array_equal(found[..., 0], expected)


def test_enlarge_pass_adds_half_of_the_detail(ctx, rng):
    pixels = noise(rng, 20, 30)
    pixels[..., :3] = 60 + pixels[..., :3] // 4
    out = ctx.texture((30, 20), 4)
    EnlargePass(ctx).run(texture_of(ctx, pixels), out)
    found = np.frombuffer(out.read(), np.uint8).reshape(20, 30, 4)[..., :3].astype(float)
    around = np.pad(pixels[..., :3].astype(float), ((1, 1), (1, 1), (0, 0)), "edge")
    for axis in (0, 1):
        a, b, c = (np.take(around, range(i, around.shape[axis] - 2 + i), axis) for i in range(3))
        around = (a + 2 * b + c) / 4
    expected = pixels[..., :3] + 0.5 * (pixels[..., :3] - around)
    np.testing.assert_allclose(found, expected, atol=tolerance_for(ctx, 0.51, 0.6))


def test_enlarge_pass_halves_error_of_linear_enlarging(ctx, rng):
    """Enlarge waves of six pixels four times: the error is under half of that without the pass."""
    x = np.arange(30) + 0.5
    pixels = np.full((8, 30, 4), 255, np.uint8)
    mean = np.sinc(1 / 6)  # of a wave over a pixel
    pixels[..., :3] = np.round(128 + 80 * mean * np.sin(2 * np.pi * x / 6))[:, None]
    sharpened = ctx.texture((30, 8), 4)
    EnlargePass(ctx).run(texture_of(ctx, pixels), sharpened)
    large = (np.arange(120) + 0.5) / 4
    wave = 128 + 80 * np.sin(2 * np.pi * large / 6)

    def error(texture: Texture) -> float:
        row = np.frombuffer(texture.read(), np.uint8).reshape(8, 30, 4)[4, :, 0]
        return float(np.abs(np.interp(large, x, row) - wave)[12:-12].mean())

    assert error(sharpened) < 0.5 * error(texture_of(ctx, pixels))
