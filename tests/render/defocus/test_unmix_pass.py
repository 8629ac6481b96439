"""The mixed pixels of silhouettes are split into a near and a far surface."""

import numpy as np
import pytest

from heatlens.core.model.boxes import Box
from heatlens.core.model.focus.coc import CocLine
from heatlens.core.model.shot.shot import Shot
from heatlens.render.defocus.listed_fragments import FragmentBuffers, ListedFragments
from heatlens.render.defocus.optics import Optics
from heatlens.render.defocus.pixel_list import list_bytes
from heatlens.render.defocus.unmix_pass import UnmixedPicture, UnmixPass
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Buffer, Texture
from heatlens.render.gpu.textures import FloatArray, new_texture, upload
from support.fragment_lists import packed_lists
from support.plates import FOCUS_M, NEAR_M, lens_blurring, plate_of

AT_INFINITY_PX = 30.0
PER_DIOPTRE_PX = -20.0
UNMIXED, FAR_EDGE, NEAR_EDGE = 0.0, 1.0, 2.0


def split_fragments(
    ctx: Device, color: FloatArray, coc: FloatArray, lists: ListedFragments | None = None
) -> dict[str, FloatArray]:
    size = coc.shape[::-1]
    color_tx, coc_tx = new_texture(ctx, size, 4), new_texture(ctx, size, 1)
    upload(color_tx, np.concatenate([color, np.ones((*coc.shape, 1), np.float32)], axis=-1))
    upload(coc_tx, coc)
    channels = (2 if lists is None else 4, 4, 4)
    kind, far, near = (new_texture(ctx, size, count, "f2") for count in channels)
    picture = UnmixedPicture(color=color_tx, coc=coc_tx, kind=kind, far=far, near=near, lists=lists)
    pixels, thin = (ctx.buffer(reserve=list_bytes(size)) for _ in range(2))
    optics = Optics(CocLine(AT_INFINITY_PX, PER_DIOPTRE_PX), np.array([0.0]))
    list(UnmixPass(ctx).steps(picture, optics, pixels, thin))

    def read(texture: Texture) -> FloatArray:
        return np.frombuffer(texture.read(), np.float16).astype(np.float32).reshape(*coc.shape, -1)

    check_rim_lists(pixels, read(kind)[..., 0])
    listed = np.float32([np.frombuffer(thin.read(16), np.uint32)[3]])
    return {"kind": read(kind)[..., 0], "far": read(far), "near": read(near), "thin": listed}


def check_rim_lists(pixels: Buffer, kind: FloatArray) -> None:
    """Check that the list has each far edge once from its start and each near edge from its end."""
    words = np.frombuffer(pixels.read(), np.uint32)
    in_front, in_back = words[12 : 12 + words[3]], words[words.size - words[7] :]
    for listed, of_kind in ((in_front, FAR_EDGE), (in_back, NEAR_EDGE)):
        expected = np.argwhere(kind == of_kind)
        assert sorted(listed.tolist()) == sorted((expected[:, 0] << 16 | expected[:, 1]).tolist())


def card_edge(coverage: float) -> tuple[FloatArray, FloatArray]:
    """Return the color and coc of a red card (columns 0-4, coc -20) before green (coc 20).

    Column 5 is covered by the card to the share `coverage`.
    """
    color = np.zeros((9, 12, 3), np.float32)
    color[:, :5] = (0.8, 0.1, 0.1)
    color[:, 5:] = (0.1, 0.7, 0.2)
    color[:, 5] = coverage * color[0, 0] + (1 - coverage) * color[0, 8]
    coc = np.full((9, 12), 20.0, np.float32)
    coc[:, :5] = -20.0
    return color, coc


def test_fragment_split_recovers_coverage_and_both_colors(ctx: Device) -> None:
    for coverage in (0.1, 0.3, 0.45):
        color, coc = card_edge(coverage)
        parts = split_fragments(ctx, color, coc)
        middle = (4, 5)
        assert parts["kind"][middle] == FAR_EDGE
        np.testing.assert_allclose(parts["far"][middle][3], coverage, atol=0.03)
        np.testing.assert_allclose(parts["far"][middle][:3], color[4, 8], atol=0.02)
        np.testing.assert_allclose(parts["near"][middle], (*color[0, 0], -20.0), atol=0.02)


def test_fragment_split_of_near_rim_recovers_its_coverage(ctx: Device) -> None:
    color, coc = card_edge(0.0)
    color[:, 4] = 0.7 * color[0, 0] + 0.3 * color[0, 8]
    parts = split_fragments(ctx, color, coc)
    assert parts["kind"][4, 4] == NEAR_EDGE
    np.testing.assert_allclose(parts["far"][4, 4], (*color[0, 0], 0.7), atol=0.03)
    assert parts["near"][4, 4, 3] == 20.0


def lists_of_known_surface(
    ctx: Device, hidden: FloatArray, behind: FloatArray, coc: float
) -> ListedFragments:
    """Return lists of one surface of a colour (H, W, 3) behind the pixels that `hidden` marks."""
    rgba = np.concatenate([behind, np.ones((*hidden.shape, 1), np.float32)], axis=-1)[hidden]
    dioptres = (coc - AT_INFINITY_PX) / PER_DIOPTRE_PX
    depth_m = np.full(len(rgba), 1 / dioptres, np.float32)
    packed = packed_lists(hidden.ravel().astype(int), np.zeros(hidden.size, bool), rgba, depth_m)
    starts, words = (ctx.buffer(array.tobytes()) for array in (packed.starts, packed.words))
    buffers = FragmentBuffers(starts, words, (hidden.shape[1], hidden.shape[0]), is_measured=False)
    return ListedFragments(buffers, CocLine(AT_INFINITY_PX, PER_DIOPTRE_PX))


@pytest.mark.parametrize("far_coc", [20.0, 0.0])
def test_known_far_side_gives_far_color_of_edge(ctx: Device, far_coc: float) -> None:
    """The pixels beside the edge are blue; the known surface at and behind the edge is green."""
    color, coc = card_edge(0.3)
    coc[:, 5:] = far_coc
    blue = np.array((0.1, 0.1, 0.9), np.float32)
    color[:, 6:] = blue  # seen one pixel further; green are the edge itself and all behind the card
    green = np.broadcast_to(np.array((0.1, 0.7, 0.2), np.float32), color.shape)
    hidden = np.broadcast_to(np.arange(color.shape[1]) < 5, coc.shape)
    guessed_far = split_fragments(ctx, color, coc)["far"][4, 5]
    known_far = split_fragments(
        ctx, color, coc, lists_of_known_surface(ctx, hidden, green, far_coc)
    )["far"][4, 5]
    off_known, off_guessed = (
        np.abs(far[:3] - green[0, 0]).max() for far in (known_far, guessed_far)
    )
    assert off_known < 0.6 * off_guessed


def test_bright_rim_of_wire_leaves_no_speck_on_known_wall_in_focus(ctx: Device) -> None:
    """The rim is brighter than the wire beside it, so that no coverage explains its pixels."""
    wall = np.broadcast_to(np.array((0.12, 0.1, 0.08), np.float32), (12, 16, 3))
    color, coc = wall.copy(), np.zeros((12, 16), np.float32)
    color[:, 6:9], coc[:, 6:9] = 0.3, -20.0
    color[:, 9] = 0.4 * 0.9 + 0.6 * wall[:, 9]
    lists = lists_of_known_surface(ctx, coc < 0, wall, 0.0)
    far = split_fragments(ctx, color, coc, lists)["far"][1:-1, 9, :3]
    assert np.abs(far - wall[0, 0]).max() < 0.05


def test_gap_between_hairs_shows_the_known_bright_wall(ctx: Device) -> None:
    """The hairs cover most of a pixel whose middle sees the wall, and no pixel sees it alone."""
    wall = np.broadcast_to(np.array((0.9, 0.5, 0.2), np.float32), (12, 24, 3))
    cover, coc = np.zeros((12, 24), np.float32), np.zeros((12, 24), np.float32)
    for column in range(4, 20, 2):
        cover[:, column], cover[:, column + 1], coc[:, column] = 0.7, 0.6, -20.0
    color = cover[..., None] * np.float32(0.02) + (1 - cover[..., None]) * wall
    lists = lists_of_known_surface(ctx, coc < 0, wall, 0.0)
    far = split_fragments(ctx, color, coc, lists)["far"][1:-1, 9:17:2, :3]
    assert np.abs(far - wall[0, 0]).max() < 0.1


def test_wire_before_known_wall_keeps_its_color_and_coverage(
    ctx: Device, rng: np.random.Generator
) -> None:
    """All pixels of a wire are edge pixels; the wall and the outline give color and coverage."""
    wall, wire = rng.random((12, 16, 3), np.float32), np.array((0.5, 0.6, 0.7), np.float32)
    color, coc = wall.copy(), np.full((12, 16), 20.0, np.float32)
    color[:, 8], coc[:, 8] = 0.75 * wire + 0.25 * wall[:, 8], -20.0
    lists = lists_of_known_surface(ctx, coc < 0, wall, 20.0)
    parts, guessed_parts = split_fragments(ctx, color, coc, lists), split_fragments(ctx, color, coc)
    assert np.all(parts["kind"][:, 8] == NEAR_EDGE)
    np.testing.assert_allclose(guessed_parts["far"][:, 8, 3], 0.75, atol=0.002)
    np.testing.assert_allclose(parts["far"][:, 8] - (*wire, 0.75), 0.0, atol=0.002)
    np.testing.assert_allclose(parts["near"][:, 8, 3], 20.0, atol=0.01)
    np.testing.assert_allclose(parts["near"][1:-1, 9, :3] - wire, 0.0, atol=0.002)


def test_textured_card_in_focus_covers_in_full_before_a_known_wall(
    ctx: Device, rng: np.random.Generator
) -> None:
    """Its texture is not taken for the wall's light, though the wall is known and blurred."""
    color, coc = rng.random((12, 16, 3), np.float32), np.full((12, 16), 20.0, np.float32)
    wall, coc[:, :8] = rng.random((12, 16, 3), np.float32), 0.0
    color[:, 8:] = wall[:, 8:]
    lists = lists_of_known_surface(ctx, coc < 10.0, wall, 20.0)
    parts = split_fragments(ctx, color, coc, lists)
    assert np.all(parts["kind"][:, 7] == NEAR_EDGE) and np.all(parts["far"][:, 7, 3] == 1.0)
    np.testing.assert_allclose(parts["far"][:, 7, :3], color[:, 7], atol=0.001)


def test_fragments_of_rim_in_focus_composite_to_its_pixel(ctx: Device) -> None:
    """The near colors vary along the edge, and colors of neighbors would show as bristles."""
    color, coc = card_edge(0.0)
    coc[:, :5] = -1.0
    color[::2, 5] = 0.45 * np.array((1.3, 0.3, 0.1)) + 0.55 * color[0, 8]
    color[1::2, 5] = 0.45 * np.array((0.5, 0.1, 0.0)) + 0.55 * color[0, 8]
    parts = split_fragments(ctx, color, coc)
    far, near, cover = parts["far"][:, 5, :3], parts["near"][:, 5, :3], parts["far"][:, 5, 3:]
    assert np.all(parts["kind"][:, 5] == FAR_EDGE) and cover.min() > 0.3
    np.testing.assert_allclose(cover * near + (1 - cover) * far, color[:, 5], atol=0.002)


def test_slanted_surface_has_no_silhouette_pixels(ctx: Device) -> None:
    coc = np.tile(np.linspace(-20, 20, 64, dtype=np.float32), (9, 1))
    color = np.full((9, 64, 3), 0.5, np.float32)
    assert np.all(split_fragments(ctx, color, coc)["kind"] == UNMIXED)


def test_silhouette_is_one_pixel_wide_on_each_side(ctx: Device) -> None:
    kind = split_fragments(ctx, *card_edge(0.5))["kind"]
    assert np.all(kind[:, 5] == FAR_EDGE)
    assert np.all(kind[:, 4] == NEAR_EDGE)
    assert np.all(np.delete(kind, (4, 5), axis=1) == UNMIXED)


def test_coverage_before_detailed_far_side_follows_outline(
    ctx: Device, rng: np.random.Generator
) -> None:
    """Coverage does not depend on the guess of a far color that varies from pixel to pixel."""
    near, shape = np.array((0.8, 0.5, 0.5), np.float32), (64, 40)
    cover = np.clip(0.25 * np.arange(shape[0])[:, None] + 2.5 - np.arange(shape[1]), 0, 1)
    far = rng.random((*shape, 3))
    color = (cover[..., None] * near + (1 - cover[..., None]) * far).astype(np.float32)
    parts = split_fragments(ctx, color, np.where(cover > 0.5, -20.0, 20.0).astype(np.float32))
    is_edge = parts["kind"] == FAR_EDGE
    error = parts["far"][..., 3][is_edge] - cover[is_edge]
    assert is_edge.sum() > 60
    assert np.sqrt(np.mean(error**2)) < 0.3  # 0.6 where the guess alone decides
    assert parts["far"][..., 3][is_edge].max() <= 0.5  # the pixel's middle shows the far side


DARK, WINDOW = (0.03, 0.02, 0.02), (0.8, 1.0, 1.1)


def hair_plate(far: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return color, coc and coverage of a hair before `far`, in column 8 and partly in column 9.

    Column 8 is fully covered in each third row.
    """
    cover = np.zeros(far.shape[:2], np.float32)
    cover[:, 8], cover[::3, 8], cover[:, 9] = 0.6, 1.0, 0.25
    coc = np.zeros_like(cover)
    coc[:, 8] = -14.0
    color = cover[..., None] * np.array(DARK, np.float32) + (1 - cover[..., None]) * far
    return color.astype(np.float32), coc, cover


def test_hair_before_window_keeps_its_color_and_coverage(ctx: Device) -> None:
    color, coc, cover = hair_plate(np.broadcast_to(np.array(WINDOW, np.float32), (18, 18, 3)))
    parts, rows = split_fragments(ctx, color, coc), slice(3, 15)
    np.testing.assert_allclose(parts["far"][rows, 8, 3], cover[rows, 8], atol=0.03)
    np.testing.assert_allclose(parts["far"][rows, 8, :3] - DARK, 0.0, atol=0.03)
    np.testing.assert_allclose(parts["far"][rows, 9, 3], cover[rows, 9], atol=0.03)
    np.testing.assert_allclose(parts["far"][rows, 9, :3] - WINDOW, 0.0, atol=0.03)


def test_hair_before_known_window_has_the_same_coverage_as_before_guessed_one(ctx: Device) -> None:
    far = np.broadcast_to(np.array(WINDOW, np.float32), (18, 18, 3))
    color, coc, cover = hair_plate(far)
    lists = lists_of_known_surface(ctx, coc < 0, far, coc=0.0)
    parts, rows = split_fragments(ctx, color, coc, lists), slice(3, 15)
    np.testing.assert_allclose(parts["far"][rows, 8, 3], cover[rows, 8], atol=0.03)
    np.testing.assert_allclose(parts["far"][rows, 8, :3] - DARK, 0.0, atol=0.03)


def test_dark_bar_behind_hair_stays_dark(ctx: Device) -> None:
    """A dark pixel beside the hair is taken as the bar, not as hair before the window."""
    far = np.broadcast_to(np.array(WINDOW, np.float32), (18, 18, 3)).copy()
    far[7:10] = (0.05, 0.05, 0.06)
    parts = split_fragments(ctx, *hair_plate(far)[:2])
    assert parts["far"][7:10, 9, :3].max() < 0.1
    assert parts["far"][7:10, 7, :3].max() < 0.1
    np.testing.assert_allclose(parts["far"][4:6, 7, :3] - WINDOW, 0.0, atol=0.03)


def test_hair_nearly_as_dark_as_far_side_covers_its_outline(ctx: Device) -> None:
    """Colors do not tell how much it covers; with what is beside it, it mixes to its pixel."""
    color, coc, _ = hair_plate(
        np.broadcast_to(np.array((0.05, 0.06, 0.04), np.float32), (18, 18, 3))
    )
    hair = split_fragments(ctx, color, coc)["far"][3:15, 8]
    np.testing.assert_allclose(hair[:, 3], 0.75, atol=0.001)
    beside = color[3:15, 7:10:2].mean(1)
    mixed = hair[:, :3] * hair[:, 3:] + beside * (1 - hair[:, 3:])
    np.testing.assert_allclose(mixed, color[3:15, 8], atol=0.001)


def test_only_rims_of_thin_surfaces_are_listed_as_thin(ctx: Device) -> None:
    """The hair has three columns of thin edges; the edge of a wide card has none."""
    color, coc, _ = hair_plate(np.broadcast_to(np.array(WINDOW, np.float32), (18, 18, 3)))
    parts = split_fragments(ctx, color, coc)
    assert parts["thin"] == 3 * 18 == (parts["kind"] != UNMIXED).sum()
    assert split_fragments(ctx, *card_edge(0.3))["thin"] == 0


def test_part_of_the_lists_keeps_the_width_of_the_whole_picture(ctx):
    starts, words = (ctx.buffer(reserve=16) for _ in range(2))
    whole = FragmentBuffers(starts, words, (30, 20), is_measured=False)
    part = whole.crop(Box(2, 3, 12, 9))
    assert (part.size, part.origin, part.stride) == ((10, 6), (2, 3), 30)
    assert part.crop(Box(4, 4, 6, 5)).stride == 30


@pytest.mark.parametrize("mixed_share", [0.6, 0.8])
def test_gap_of_a_pixel_between_blurred_stems_leaves_no_line_on_wall_in_focus(
    ctx, renderer, mixed_share: float
) -> None:
    """It was darker than the pixels beside it by 20 and 33 %."""
    wall, stem, gap = 0.6, 0.05, 48
    column = np.arange(96)
    is_stem = (abs(column - gap) <= 5) & (column != gap)
    light = np.where(is_stem, stem, wall)
    light[gap] = mixed_share * stem + (1 - mixed_share) * wall
    color = np.broadcast_to(light[None, :, None], (32, 96, 3)).astype(np.float32)
    depth_m = np.broadcast_to(np.where(is_stem, NEAR_M, FOCUS_M), (32, 96)).astype(np.float32)
    renderer.load(plate_of(color, depth_m))
    row = renderer.pixels(Shot(lens_blurring(24.0, 96)))[16, :, 0]
    assert row[gap] < 0.9 * wall  # the stems are spread over the gap
    beside = (row[gap - 1] + row[gap + 1]) / 2
    assert row[gap] == pytest.approx(beside, rel=0.1)
