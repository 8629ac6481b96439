"""Lamps: taken out, listed within bounds, drawn with their light."""

from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from heatlens.core.model.lens.aperture import Aperture
from heatlens.core.model.lens.disc_shape import DiscShape, PictureField
from heatlens.render.defocus.blur_pass import PACKED, BlurPass, BlurTargets
from heatlens.render.defocus.highlights import highlight_list, highlight_shadow
from heatlens.render.defocus.highlights.highlight_draw import HighlightDrawPass
from heatlens.render.defocus.highlights.highlight_list import (
    SMALL_SPRITES_MAX,
    HighlightBuffers,
    HighlightListPass,
)
from heatlens.render.defocus.highlights.highlight_shadow import (
    HighlightShadowPass,
    RayMemory,
    nodes_bytes,
)
from heatlens.render.defocus.highlights.highlight_split import (
    HighlightSplitPass,
    Surroundings,
    WithoutHighlights,
)
from heatlens.render.defocus.line_solver import SweepSolver
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.unmix_pass import UnmixedPicture
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import blocks_for
from heatlens.render.gpu.resources import Buffer
from heatlens.render.gpu.shader_constants import HIGHLIGHT_BLOCK, TILE
from heatlens.render.gpu.textures import FloatArray, download, new_array, new_texture, upload
from support.opening_images import letter

ROUND, ANAMORPHIC = DiscShape(), DiscShape(Aperture(squeeze=2.0), 1.5)
FIELD = PictureField.of((96, 96))
WITH_BLADES = DiscShape(Aperture(blades=5, blade_rotation_deg=10.0, blade_curvature=0.3))
WITH_CAT_EYE = DiscShape(Aperture(blades=9, cat_eye=1.0, rim=0.8), 1.0, FIELD)
WITH_APERTURE_IMAGE = DiscShape(Aperture(rim=0.4, cat_eye=0.6, aperture_image=letter()), 1.0, FIELD)
WITH_AXIAL_COLOR = DiscShape(Aperture(axial_colour_mm=1.0), 1.0, FIELD, axial_px=6.0)


class HighlightPasses:
    """The highlight passes. They are kept for all tests, as their programs take long to build."""

    def __init__(self, ctx: Device) -> None:
        self.solver = SweepSolver(ctx)
        self.split = HighlightSplitPass(ctx, BlurPass(self.solver))
        self.lists = HighlightListPass(ctx)
        self.shading, self.drawing = HighlightShadowPass(ctx), HighlightDrawPass(ctx)


passes_of = lru_cache(maxsize=1)(HighlightPasses)


class RenderedLamps:
    """The results of the highlight passes on one picture."""

    def __init__(
        self, ctx: Device, color: FloatArray, coc: FloatArray, disc: DiscShape = ROUND
    ) -> None:
        size = coc.shape[::-1]
        self.optics = Optics(None, np.array([coc.min(), coc.max()], np.float64), disc)
        self.color, self.coc = new_texture(ctx, size, 4), new_texture(ctx, size, 1)
        upload(self.color, np.concatenate([color, np.ones((*coc.shape, 1))], -1))
        upload(self.coc, coc)
        self.diffuse, self.highlights, self.out = (new_texture(ctx, size, 4) for _ in range(3))
        sizes = HighlightBuffers.sizes(size)
        self.buffers = HighlightBuffers(**{k: ctx.buffer(reserve=v) for k, v in sizes.items()})
        self._passes, half = passes_of(ctx), blocks_for(size, 2)
        poles = new_array(ctx, self._passes.solver.size_between_axes(half), 1, 4, PACKED)
        scratch = Surroundings(
            luminance=new_texture(ctx, half, 4),
            coc=new_texture(ctx, half, 1),
            targets=BlurTargets(poles, new_texture(ctx, half, 4)),
        )
        lit = ctx.buffer(reserve=WithoutHighlights.lit_bytes(size))
        into = WithoutHighlights(
            self.diffuse, self.highlights, lit, new_texture(ctx, half, 1, "f2")
        )
        list(self._passes.split.steps(self.color, self.coc, self.optics, scratch, into))
        self.taken = np.where(
            lit_pixels(lit, size)[..., None], download(self.highlights)[..., :3], 0.0
        )
        list(self._passes.lists.steps(into, self.optics, self.buffers, self.coc))
        kind, far, near = (new_texture(ctx, size, channels, "f2") for channels in (2, 4, 4))
        for empty in (self.out, far, near):  # what a driver hands out may be anything
            empty.write(bytes(size[0] * size[1] * empty.components * int(empty.dtype[1])))
        kind.write(np.stack([0 * coc, coc], -1).astype(np.float16))  # unmixed; its nearest surface
        self._ctx, self._picture = ctx, UnmixedPicture(self.color, self.coc, kind, far, near)
        self.draw(coc_range_of_tiles(coc))

    def draw(self, coc_range: FloatArray) -> None:
        """Draw into `out`; `coc_range` has the least and the greatest coc of each tile."""
        self.out.write(bytes(16 * self.out.width * self.out.height))
        of_tiles = new_texture(self._ctx, (coc_range.shape[1], coc_range.shape[0]), 2)
        upload(of_tiles, coc_range)
        size, inputs = self.out.size, (self.buffers, self._picture)
        ranges, edges = (new_texture(self._ctx, size, channels) for channels in (2, 1))
        rays = RayMemory(ranges, edges, self._ctx.buffer(reserve=nodes_bytes(size)))
        list(self._passes.shading.steps(*inputs, of_tiles, self.optics, rays))
        list(self._passes.drawing.steps(*inputs, self.optics, rays, self.out))

    @property
    def count(self) -> int:
        return int(np.frombuffer(self.buffers.plan.read(), np.uint32)[1])

    @property
    def drawn(self) -> FloatArray:
        return download(self.out)[..., :3]


def lit_pixels(lit: Buffer, size: tuple[int, int]) -> NDArray[np.bool_]:
    """Return the bits of lib/lit_bits.lib.glsl as a picture."""
    across, down = blocks_for(size, HIGHLIGHT_BLOCK)
    bits = np.unpackbits(np.frombuffer(lit.read(), np.uint8), bitorder="little")
    blocks = bits.reshape(down, across, HIGHLIGHT_BLOCK, HIGHLIGHT_BLOCK).swapaxes(1, 2)
    whole = blocks.reshape(down * HIGHLIGHT_BLOCK, across * HIGHLIGHT_BLOCK)
    return whole[: size[1], : size[0]].astype(bool)


def coc_range_of_tiles(coc: FloatArray) -> FloatArray:
    down, across = (-(-side // TILE) for side in coc.shape)
    whole = np.pad(
        coc,
        [(0, TILE * n - side) for n, side in zip((down, across), coc.shape, strict=True)],
        "edge",
    )
    tiles = whole.reshape(down, TILE, across, TILE)
    return np.stack([tiles.min(axis=(1, 3)), tiles.max(axis=(1, 3))], -1)


def dark_picture_with_lamps(
    shape: tuple[int, int], lamps: dict[tuple[int, int], float]
) -> FloatArray:
    color = np.full((*shape, 3), 0.05, np.float32)
    for place, brightness in lamps.items():
        color[place] = (brightness, 0.8 * brightness, 0.5 * brightness)
    return color


@pytest.mark.parametrize("disc", [ROUND, ANAMORPHIC, WITH_BLADES, WITH_CAT_EYE, WITH_AXIAL_COLOR])
@pytest.mark.parametrize("coc_px", [1.0, 3.0, 8.0, 15.0, -40.0])
def test_highlights_keep_light(ctx: Device, coc_px: float, disc: DiscShape) -> None:
    color = dark_picture_with_lamps((96, 96), {(48, 48): 100.0, (40, 60): 30.0})
    lamps = RenderedLamps(ctx, color, np.full((96, 96), coc_px, np.float32), disc)
    assert lamps.count == 2
    diffuse = download(lamps.diffuse)[..., :3]
    total = (diffuse + lamps.drawn).sum(axis=(0, 1), dtype=np.float64)
    np.testing.assert_allclose(total, color.sum(axis=(0, 1), dtype=np.float64), rtol=2e-3)


def test_least_coc_of_tiles_does_not_change_occlusion(
    ctx: Device, rng: np.random.Generator
) -> None:
    """The least coc of the whole picture gives the same occlusion as the least coc of each tile."""
    places = rng.integers(0, 300, (60, 2))
    color = dark_picture_with_lamps((300, 300), {(int(y), int(x)): 60.0 for y, x in places})
    coc = np.full((300, 300), 14.0, np.float32)
    coc[100:200, ::7], coc[:90, 200:], coc[280:, :20] = 1.0, -9.0, -60.0
    lamps = RenderedLamps(ctx, color, coc)
    by_tile, of_tiles = lamps.drawn, coc_range_of_tiles(coc)
    of_tiles[..., 0] = coc.min()
    lamps.draw(of_tiles)
    assert lamps.count > 20 and np.array_equal(lamps.drawn, by_tile)
    of_tiles[...] = 14.0  # nothing nearer is known of: nothing hides
    lamps.draw(of_tiles)
    assert not np.array_equal(lamps.drawn, by_tile)
    of_tiles[...] = -99.0  # all that is seen is nearer than the lamps, which some list has then
    lamps.draw(of_tiles)
    assert not lamps.drawn.any()


def test_rays_of_small_discs_are_those_of_drawn_pixels(
    ctx: Device, rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where a list has no room for the nodes of discs, each drawn pixel traces its rays."""
    places = rng.integers(0, 120, (60, 2))
    color = dark_picture_with_lamps((120, 120), {(int(y), int(x)): 60.0 for y, x in places})
    coc = np.linspace(0.5, 12.0, 120, dtype=np.float32) * np.ones((120, 1), np.float32)
    coc[:, ::7] = -9.0
    lamps = RenderedLamps(ctx, color, coc)
    at_nodes = lamps.drawn
    monkeypatch.setattr(highlight_shadow, "nodes_most", lambda _: 0)
    lamps.draw(coc_range_of_tiles(coc))
    assert lamps.count > 20 and at_nodes.max() > 1.0
    np.testing.assert_allclose(at_nodes, lamps.drawn, atol=1e-4 * at_nodes.max())


def test_gpu_lists_same_highlights_as_software(
    ctx: Device, rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A GPU merges all levels at once; it lists lamps in the order of the picture too."""
    places = rng.integers(0, 160, (40, 2))
    color = dark_picture_with_lamps((160, 160), {(int(y), int(x)): 60.0 for y, x in places})
    coc = np.linspace(-30.0, 30.0, 160, dtype=np.float32) * np.ones((160, 1), np.float32)
    software = RenderedLamps(ctx, color, coc)
    monkeypatch.setattr(highlight_list, "is_software", lambda _: False)
    gpu = RenderedLamps(ctx, color, coc)
    assert gpu.count == software.count > 20
    on_gpu, on_software = (
        np.frombuffer(lamps.buffers.sprite.read(48 * gpu.count), np.float32).reshape(-1, 12)
        for lamps in (gpu, software)
    )
    assert np.array_equal(on_gpu[:, :8], on_software[:, :8])
    centres = on_gpu[:, :2]
    rows, columns = (centres[:, 1] - 0.01) // 8, (centres[:, 0] - 0.01) // 8
    assert np.all(np.diff(20 * rows + columns) >= 0)


@pytest.mark.parametrize("coc_px", [3.0, -40.0])
def test_highlights_with_aperture_image_keep_light(ctx: Device, coc_px: float) -> None:
    test_highlights_keep_light(ctx, coc_px, WITH_APERTURE_IMAGE)


def test_highlight_is_disc_of_its_circle_of_confusion(ctx: Device) -> None:
    lamps = RenderedLamps(
        ctx,
        color=dark_picture_with_lamps((80, 80), {(40, 40): 200.0}),
        coc=np.full((80, 80), 30.0, np.float32),
    )
    drawn = lamps.drawn[..., 0]
    y, x = np.mgrid[:80, :80]
    radius = np.hypot(y - 40, x - 40)
    plateau = drawn[radius < 13].mean()
    np.testing.assert_allclose(drawn[radius < 13.5], plateau, rtol=1e-4)
    assert np.all(drawn[radius > 16.5] == 0.0)
    assert np.count_nonzero(drawn > plateau / 2) == pytest.approx(np.pi * 15**2, rel=0.02)


def test_highlight_of_squeezed_lens_is_ellipse(ctx: Device) -> None:
    lamps = RenderedLamps(
        ctx,
        color=dark_picture_with_lamps((80, 80), {(40, 40): 200.0}),
        coc=np.full((80, 80), 40.0, np.float32),
        disc=ANAMORPHIC,
    )
    drawn = lamps.drawn[..., 0]
    y, x = np.mgrid[:80, :80] - 40
    from_centre = np.hypot(x / 10, y / 30)  # half of 40 px, narrower by 2 and lower by 1.5
    plateau = drawn[from_centre < 0.8].mean()
    np.testing.assert_allclose(drawn[from_centre < 0.85], plateau, rtol=1e-4)
    assert np.all(drawn[from_centre > 1.15] == 0.0)
    assert np.count_nonzero(drawn > plateau / 2) == pytest.approx(np.pi * 10 * 30, rel=0.02)


@pytest.mark.parametrize("disc", [WITH_BLADES, WITH_CAT_EYE, WITH_AXIAL_COLOR, WITH_APERTURE_IMAGE])
@pytest.mark.parametrize("coc_px", [40.0, -36.0])
def test_highlight_has_shape_of_opening(ctx: Device, disc: DiscShape, coc_px: float) -> None:
    """Each pixel and color matches the coverage of the aperture at the position of the lamp."""
    lamps = RenderedLamps(
        ctx,
        color=dark_picture_with_lamps((96, 96), {(30, 60): 200.0}),
        coc=np.full((96, 96), coc_px, np.float32),
        disc=disc,
    )
    y, x = np.mgrid[:96, :96] + 0.5
    place = 60.5, 30.5
    for color in range(3):
        radius = (coc_px + (color - 1) * disc.axial_px) / 2
        expected = disc.coverage(x - place[0], y - place[1], radius, 0.5, place)
        drawn = lamps.drawn[..., color]
        np.testing.assert_allclose(drawn / drawn.sum(), expected / expected.sum(), atol=2e-5)


FINE = 16  # points along a pixel's side


def round_lamp(side: int, middle: tuple[float, float], radius_px: float) -> FloatArray:
    """Return a lamp of brightness 100 at FINE x FINE points of each pixel."""
    at = (np.arange(FINE * side) + 0.5) / FINE
    return np.where(np.hypot(at[:, None] - middle[0], at - middle[1]) < radius_px, 100.0, 0.0)


def pixels_of(fine: FloatArray) -> FloatArray:
    side = len(fine) // FINE
    return fine.reshape(side, FINE, side, FINE).mean(axis=(1, 3))


def defocus_by_fft(fine: FloatArray, coc_px: float) -> FloatArray:
    """Return the picture with each point spread to a disc; it wraps around at the borders."""
    side = len(fine)
    at = np.minimum(np.arange(side), side - np.arange(side)) / FINE
    disc = (np.hypot(at[:, None], at) < coc_px / 2).astype(np.float64)
    return np.fft.irfft2(np.fft.rfft2(fine) * np.fft.rfft2(disc / disc.sum()), fine.shape)


def lamp_disc_at(ctx: Device, coc_px: float) -> FloatArray:
    """Return the disc of a lamp of one pixel, as shares of its light."""
    coc = np.full((24, 24), coc_px, np.float32)
    drawn = (
        RenderedLamps(ctx, dark_picture_with_lamps((24, 24), {(12, 12): 200.0}), coc)
        .drawn[..., 0]
        .astype(np.float64)
    )
    return drawn / drawn.sum()


@settings(max_examples=25)
@given(st.floats(1.0, 10.0))
def test_small_highlight_disc_covers_pixels_as_its_coc(
    session_context: Device, coc_px: float
) -> None:
    """Each pixel has the share of the disc that it covers, also where the disc is a few pixels."""
    fine = np.zeros((24 * FINE, 24 * FINE))
    fine[12 * FINE + 7 : 12 * FINE + 9, 12 * FINE + 7 : 12 * FINE + 9] = 0.25
    expected = pixels_of(defocus_by_fft(fine, coc_px))
    for sign in (1.0, -1.0):
        misplaced = np.abs(lamp_disc_at(session_context, sign * coc_px) - expected / expected.sum())
        assert misplaced.sum() / 2 < 0.04


def test_small_highlight_disc_grows_evenly_with_coc(ctx: Device) -> None:
    """The disc never reaches a ring of pixels at once, which a slow focus pull shows as a step."""
    discs = np.array([lamp_disc_at(ctx, coc_px) for coc_px in np.arange(1.0, 6.0, 0.05)])
    bends = np.abs(discs[2:] - 2 * discs[1:-1] + discs[:-2]).sum(axis=(1, 2))
    assert bends.max() < 0.04


@pytest.mark.parametrize(("coc_px", "error_limit"), [(2.0, 0.1), (4.0, 0.06)])
def test_small_lamp_is_drawn_at_its_subpixel_position(ctx, rng, coc_px, error_limit) -> None:
    """Compare with the finely sampled lamp; discs at pixel centers have twice the error."""
    misplaced = []
    for _ in range(12):
        fine = round_lamp(32, tuple(rng.uniform(15.5, 16.5, 2)), rng.uniform(0.3, 2.5))
        color = np.repeat(pixels_of(fine)[..., None].astype(np.float32), 3, -1)
        lamps = RenderedLamps(ctx, color, np.full((32, 32), coc_px, np.float32))
        drawn = download(lamps.diffuse)[..., 0] + lamps.drawn[..., 0]
        wrong = np.abs(drawn - pixels_of(defocus_by_fft(fine, coc_px)))
        misplaced.append(wrong.sum() / drawn.sum())
    assert np.mean(misplaced) < error_limit


def test_wall_in_front_hides_only_part_of_highlight_disc(ctx: Device) -> None:
    coc = np.full((80, 120), 30.0, np.float32)
    coc[:, :55] = 0.0  # a wall in focus, left of a lamp at column 60
    lamps = RenderedLamps(ctx, dark_picture_with_lamps((80, 120), {(40, 60): 200.0}), coc)
    drawn = lamps.drawn[..., 0]
    assert np.all(drawn[:, :54] == 0.0)
    assert drawn[40, 70] > 0.0


def test_lamp_in_focus_is_no_highlight(ctx: Device) -> None:
    color = dark_picture_with_lamps((40, 40), {(20, 20): 100.0})
    lamps = RenderedLamps(ctx, color, np.zeros((40, 40), np.float32))
    assert lamps.count == 0
    assert np.array_equal(download(lamps.diffuse)[..., :3], color)


def test_near_lamps_merge_and_distant_ones_do_not(ctx: Device) -> None:
    cluster = {(33 + i, 33 + j): 50.0 for i in range(3) for j in range(3)}
    color = dark_picture_with_lamps((80, 80), cluster | {(60, 60): 50.0})
    assert RenderedLamps(ctx, color, np.full((80, 80), 130.0, np.float32)).count == 2
    assert RenderedLamps(ctx, color, np.full((80, 80), 8.0, np.float32)).count == 10


def test_too_many_lamps_stay_in_picture_without_highlights(
    ctx: Device, rng: np.random.Generator
) -> None:
    """Sparks everywhere under a wide blur: more disc pixels than the bound at every level."""
    color = dark_picture_with_lamps((256, 256), {})
    color[rng.random((256, 256)) < 0.05] = 40.0
    lamps = RenderedLamps(ctx, color, np.full((256, 256), 250.0, np.float32))
    assert lamps.taken.sum() > 0
    assert lamps.count == 0
    np.testing.assert_allclose(download(lamps.diffuse)[..., :3], color, rtol=1e-5)
    assert np.all(lamps.drawn == 0.0)


def test_highlight_split_marks_pixels_that_hold_light(ctx: Device) -> None:
    """The picture ends within a block, and lamps lie at its edges."""
    places = {(0, 0): 60.0, (7, 8): 60.0, (40, 66): 60.0, (43, 61): 60.0}
    color = dark_picture_with_lamps((44, 67), places)
    lamps = RenderedLamps(ctx, color, np.full((44, 67), 8.0, np.float32))
    assert {(y, x) for y, x in np.argwhere(lamps.taken.any(axis=2)).tolist()} == places.keys()
    np.testing.assert_allclose(download(lamps.diffuse)[..., :3] + lamps.taken, color, rtol=1e-6)


def test_only_blocks_with_light_are_listed_for_merging(ctx: Device) -> None:
    """The number of listed blocks decides the cost of merging."""
    places = {(3, 5): 60.0, (7, 8): 60.0, (40, 61): 60.0, (41, 62): 60.0}
    lamps = RenderedLamps(
        ctx, color=dark_picture_with_lamps((64, 67), places), coc=np.full((64, 67), 8.0, np.float32)
    )
    words = np.frombuffer(lamps.buffers.blocks.read(), np.uint32)
    listed = {(word >> 16, word & 0xFFFF) for word in words[4 : 4 + words[3]].tolist()}
    assert listed == {(y // 8, x // 8) for y, x in places}


def test_highlight_list_is_bounded_and_reproducible(ctx: Device, rng: np.random.Generator) -> None:
    color = dark_picture_with_lamps((512, 512), {})
    color[rng.random((512, 512)) < 0.02] = 40.0
    coc = np.full((512, 512), 4.0, np.float32)
    first, second = RenderedLamps(ctx, color, coc), RenderedLamps(ctx, color, coc)
    assert 0 < first.count <= SMALL_SPRITES_MAX
    assert np.array_equal(first.drawn, second.drawn)


def test_lamps_of_wide_blur_are_drawn_as_highlights(ctx: Device) -> None:
    """All lamps are highlights, though each disc is a quarter of the picture wide."""
    places = {(int(128 + 60 * np.sin(i)), int(16 + 11.2 * i)): 60.0 for i in range(20)}
    lamps = RenderedLamps(
        ctx, dark_picture_with_lamps((256, 256), places), np.full((256, 256), 64.0, np.float32)
    )
    assert lamps.count == 20


@pytest.mark.parametrize("disc", [WITH_CAT_EYE, WITH_AXIAL_COLOR])
def test_block_full_of_lamps_keeps_light(ctx: Device, disc: DiscShape) -> None:
    """Each pixel of the block is a disc, so one invocation sums the light in many rounds."""
    if ctx.library == "wgpu" and ctx.is_software and disc is WITH_AXIAL_COLOR:
        pytest.skip("Mesa ends all loops of an invocation after 65,535 rounds, more by wgpu")
    color = dark_picture_with_lamps(
        (64, 64), {(y, x): 50.0 for y in range(24, 40) for x in range(24, 40)}
    )
    coc = np.full((64, 64), 12.0, np.float32) + 1.5 * np.random.default_rng(0).random((64, 64))
    lamps = RenderedLamps(ctx, color, coc.astype(np.float32), disc)
    total = (download(lamps.diffuse)[..., :3] + lamps.drawn).sum(axis=(0, 1), dtype=np.float64)
    np.testing.assert_allclose(total, color.sum(axis=(0, 1), dtype=np.float64), rtol=4e-3)


def test_large_bright_surface_stays_even(ctx: Device) -> None:
    """The surface is not merged to discs by blocks, which shows a pattern; a spark beside it is."""
    color = dark_picture_with_lamps((128, 128), {(8, 8): 400.0})
    color[16:112, 16:112] = 100.0
    assert 96 * 96 > SMALL_SPRITES_MAX
    lamps = RenderedLamps(ctx, color, np.full((128, 128), 1.5, np.float32))
    picture = download(lamps.diffuse)[..., :3] + lamps.drawn
    np.testing.assert_allclose(picture[20:108, 20:108], 100.0, rtol=0.02)
    assert 0 < lamps.count < 96
    total = picture.sum(axis=(0, 1), dtype=np.float64)
    np.testing.assert_allclose(total, color.sum(axis=(0, 1), dtype=np.float64), rtol=4e-3)


def test_large_lamp_among_many_sparks_is_highlight(ctx: Device, rng: np.random.Generator) -> None:
    """The lamp is drawn as discs; diffusion of its light leaves a dark ring on the wall."""
    color = dark_picture_with_lamps((512, 512), {})
    color[8:-8, 8:-8][rng.random((496, 496)) < 0.02] = 40.0  # no disc crosses the border
    coc = np.full((512, 512), 4.0, np.float32)
    color[200:224, 200:224], coc[192:232, 192:232] = 32.0, -26.0
    lamps = RenderedLamps(ctx, color, coc)
    assert 0 < lamps.count <= SMALL_SPRITES_MAX
    diffuse = download(lamps.diffuse)[..., :3]
    assert diffuse[200:224, 200:224].max() < 4.0
    total = (diffuse + lamps.drawn).sum(axis=(0, 1), dtype=np.float64)
    np.testing.assert_allclose(total, color.sum(axis=(0, 1), dtype=np.float64), rtol=4e-3)
