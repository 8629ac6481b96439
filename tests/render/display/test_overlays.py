"""Overlays compared with the same formulas in NumPy, for depth plates and coc plates."""

import math
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from heatlens.core.model.focus.coc import coc_line, coc_px, sharp_px
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.view.guides import PEAKING_COLORS, USUAL_PEAKING, Peaking, PeakingOn
from heatlens.core.model.view.overlays import OVERLAYS, overlay_of, overlays_by_name
from heatlens.media.plate.plate import Plate
from heatlens.render.defocus.layer_cuts import layer_cuts
from heatlens.render.display.overlay_pass import OverlayPass
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.textures import new_texture, upload
from heatlens.render.source.pinhole import optics_of
from support.plates import coc_plate_of, plate_of, room

LENS = Lens(50.0, 2.0, 2.0, 36.0, acceptable_coc_mm=0.2)
ORANGE, YELLOW, BLUE = (214, 94, 0), (240, 227, 66), (0, 114, 178)
TINT = 107
PLANE = 0.9 * 255  # renderers round it up or down
LIMITS = (-10.0, -4.0, -1.0, 2.0)
RGB_TO_XYZ = np.array(
    ((0.4124, 0.3576, 0.1805), (0.2126, 0.7152, 0.0722), (0.0193, 0.1192, 0.9505))
)
# What eyes without red or green cones see of linear light: F. Vienot, H. Brettel, J. Mollon 1999.
EYES = {
    "usual": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "without red": ((0.11238, 0.88762, 0.0), (0.11238, 0.88762, 0.0), (0.00401, -0.00401, 1.0)),
    "without green": (
        *((0.29275, 0.70725, 0.0), (0.29275, 0.70725, 0.0)),
        (-0.02234, 0.02234, 1.0),
    ),
}


@pytest.fixture(scope="module")
def overlays(session_context) -> OverlayPass:
    return OverlayPass(session_context)


def room_plate(width: int = 77, height: int = 53) -> Plate:
    return plate_of(*room(width, height))


def coc_room(width: int = 77, height: int = 53) -> Plate:
    """Return the same room as a coc plate."""
    color, depth = room(width, height)
    return coc_plate_of(color, coc_px(depth, coc_line(LENS, width)))


def coc_of(plate: Plate, lens: Lens = LENS) -> np.ndarray:
    if plate.coc_px is not None:
        return plate.coc_px.astype(np.float64)
    return coc_px(plate.depth_m, coc_line(lens, plate.display_window.width))


def draw_overlay(
    overlays: OverlayPass,
    ctx: Device,
    overlay: str,
    plate: Plate,
    lens: Lens = LENS,
    limits: tuple[float, ...] = LIMITS,
    peaking: Peaking | None = None,
    light: np.ndarray | None = None,
) -> np.ndarray:
    """Return (H, W, 4) bytes; `light` replaces that of the plate."""
    values = plate.coc_px if plate.depth_m is None else plate.depth_m
    size = values.shape[::-1]
    depth, out = new_texture(ctx, size, 1), ctx.texture(size, 4)
    upload(depth, values)
    optics = optics_of(plate, plate.bins, lens)
    sharp = sharp_px(lens, plate.display_window.width)
    light = plate.color[..., :3] if light is None else light
    color = new_texture(ctx, light.shape[1::-1], 4)
    rgba = np.dstack([light, np.ones(light.shape[:2], np.float32)])
    upload(color, np.ascontiguousarray(rgba, np.float32))
    overlays.run(overlay, depth, optics, sharp, limits, out, color, peaking)
    color.release()
    pixels = np.frombuffer(out.read(), np.uint8).reshape(*values.shape, 4)
    depth.release()
    out.release()
    return pixels


PLATES = pytest.mark.parametrize("make", [room_plate, coc_room], ids=["distances", "coc"])
LENSES = pytest.mark.parametrize(
    "lens",
    [LENS, replace(LENS, focus_distance_m=math.inf), replace(LENS, focus_distance_m=0.5)],
    ids=["2 m", "infinity", "in front of all"],
)


@PLATES
@LENSES
def test_zones_show_sign_of_coc_and_acceptable_sharpness(ctx, overlays, make, lens):
    plate = make()
    coc, sharp = coc_of(plate, lens), sharp_px(lens, 77)
    zones = draw_overlay(overlays, ctx, "zones", plate, lens)
    assert np.all(zones[..., 3] == TINT)
    is_certain = abs(abs(coc) - sharp) > 1e-5 * (1 + abs(coc))
    expected = np.where((abs(coc) <= sharp)[..., None], YELLOW, BLUE)
    expected = np.where((coc < -sharp)[..., None], ORANGE, expected)
    np.testing.assert_array_equal(zones[is_certain][:, :3], expected[is_certain])
    assert is_certain.mean() > 0.99


def test_zones_overlay_of_room_has_three_colors(ctx, overlays):
    found = draw_overlay(overlays, ctx, "zones", room_plate())
    assert {tuple(color) for color in found.reshape(-1, 4)[:, :3]} == {ORANGE, YELLOW, BLUE}


def seen_lab(display: tuple[float, ...], cones: np.ndarray) -> np.ndarray:
    """Return the CIE Lab of an sRGB colour for eyes that see linear light through `cones`."""
    srgb = np.array(display)
    light = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    part = RGB_TO_XYZ @ np.clip(cones @ light, 0.0, 1.0) / RGB_TO_XYZ.sum(axis=1)
    x, y, z = np.where(part > 0.008856, np.cbrt(part), 7.787 * part + 16 / 116)
    return np.array((116 * y - 16, 500 * (x - y), 200 * (y - z)))


@pytest.mark.parametrize("cones", EYES.values(), ids=EYES)
def test_zone_colors_differ_for_color_blind_eyes(cones):
    colors = overlay_of("zones").tints()
    zones = [seen_lab(color, np.array(cones)) for color in colors]
    distances = [float(np.linalg.norm(a - b)) for a, b in combinations(zones, 2)]
    assert min(distances) > 30


def test_zones_count_limit_coc_as_sharp(ctx, overlays):
    limit = np.float32(sharp_px(LENS, 4))
    beyond = np.nextafter(limit, np.float32(9))
    plate = coc_plate_of(
        np.zeros((1, 4, 3), np.float32), np.array([[-beyond, -limit, limit, beyond]])
    )
    found = draw_overlay(overlays, ctx, "zones", plate)[0, :, :3]
    np.testing.assert_array_equal(found, [ORANGE, YELLOW, YELLOW, BLUE])


@LENSES
def test_depth_overlay_is_grey_and_linear_in_dioptres(ctx, overlays, lens):
    """Check that depth is linear in dioptres for any lens: nearest surface white, sky black."""
    plate = room_plate()
    found = draw_overlay(overlays, ctx, "depth", plate, lens)
    dioptres = 1.0 / plate.depth_m.astype(np.float64)
    np.testing.assert_allclose(found[..., 0], 255 * dioptres / dioptres.max(), atol=0.6)
    assert np.all(found[..., :3] == found[..., :1]) and np.all(found[..., 3] == 255)
    order = np.argsort(plate.depth_m, axis=None)
    assert np.all(np.diff(found[..., 0].ravel()[order].astype(int)) <= 0)


def test_depth_overlay_of_coc_plate_is_white_in_front(ctx, overlays):
    plate = coc_room()
    found = draw_overlay(overlays, ctx, "depth", plate)[..., 0]
    low, high = plate.coc_px.min(), plate.coc_px.max()
    np.testing.assert_allclose(found, 255 * (high - plate.coc_px) / (high - low), atol=0.6)


def test_depth_overlay_of_wall_is_uniform(ctx, overlays):
    wall = plate_of(np.zeros((5, 7, 3), np.float32), np.full((5, 7), 3.0, np.float32))
    assert len(np.unique(draw_overlay(overlays, ctx, "depth", wall)[..., 0])) == 1


@PLATES
@pytest.mark.parametrize("limits", [LIMITS, (), (0.0,)])
def test_layers_overlay_tints_each_layer_between_limits(ctx, overlays, make, limits):
    plate = make()
    coc = coc_of(plate)
    found = draw_overlay(overlays, ctx, "layers", plate, limits=limits)
    colors, layer = np.unique(found.reshape(-1, 4), axis=0, return_inverse=True)
    expected = np.searchsorted(np.array(limits), coc.ravel())
    sure = np.all([abs(coc.ravel() - limit) > 1e-4 for limit in (*limits, 1e9)], axis=0)
    pairs = {(int(a), int(b)) for a, b in zip(layer[sure], expected[sure], strict=True)}
    assert len(pairs) == len(colors) == len(np.unique(expected[sure]))  # a tint each
    assert np.all(found[..., 3] == 140)


def test_layers_overlay_has_tint_for_each_of_eight_layers(ctx, overlays):
    coc = np.arange(-4, 4, dtype=np.float32).reshape(1, 8)
    plate = coc_plate_of(np.zeros((1, 8, 3), np.float32), coc)
    limits = tuple(np.arange(-3.5, 3.5))
    found = draw_overlay(overlays, ctx, "layers", plate, limits=limits)
    assert len(np.unique(found.reshape(8, 4), axis=0)) == 8


def test_layers_overlay_fits_limits_of_renderer(ctx, overlays):
    """Pass the cuts between the plate's layers, as the window does."""
    plate = room_plate(192, 108)
    optics = optics_of(plate, plate.bins, replace(LENS, f_stop=0.7))
    cuts = layer_cuts(optics.occupied_px, optics.gaps_px, 7)
    limits = tuple(sorted(cut.near.at_px for cut in cuts if not cut.is_nearest))
    found = draw_overlay(overlays, ctx, "layers", plate, replace(LENS, f_stop=0.7), limits)
    assert len(limits) == len(cuts) - 1 >= 3
    assert len(np.unique(found.reshape(-1, 4), axis=0)) == len(cuts)


@PLATES
def test_coc_overlay_color_grows_with_coc(ctx, overlays, make):
    """Check amber before and blue behind the focus, on a logarithmic scale, dark green if sharp."""
    plate = make()
    coc, sharp = coc_of(plate), sharp_px(LENS, 77)
    found = draw_overlay(overlays, ctx, "coc", plate).astype(float)
    part = np.log2(1 + abs(coc)) / np.log2(1 + max(abs(coc).max(), 2 * sharp))
    hue = np.where((coc < 0)[..., None], (1.0, 0.55, 0.12), (0.2, 0.6, 1.0))
    expected = 0.06 + part[..., None] * (hue - 0.06)
    expected = np.where((abs(coc) <= sharp)[..., None], (0.10, 0.30, 0.14), expected)
    sure = abs(abs(coc) - sharp) > 1e-5 * (1 + abs(coc))
    np.testing.assert_allclose(found[sure][:, :3], 255 * expected[sure], atol=0.7)
    assert np.all(found[..., 3] == 255)


def ramp_plate(width: int = 240) -> Plate:
    """Return a floor: dioptres falling evenly from 1 at the left to 0.2 at the right."""
    dioptres = np.tile(np.linspace(1.0, 0.2, width), (6, 1))
    return plate_of(np.zeros((6, width, 3), np.float32), (1 / dioptres).astype(np.float32))


@pytest.mark.parametrize("focus_m", [1.25, 2.0, 3.3])
def test_focus_plane_overlay_is_a_line_at_focus_distance(ctx, overlays, focus_m):
    lens = replace(LENS, focus_distance_m=focus_m, acceptable_coc_mm=0.05)
    alpha = draw_overlay(overlays, ctx, "focus plane", ramp_plate(), lens)[..., 3]
    column = (1.0 - 1.0 / focus_m) / 0.8 * 239
    lit = np.flatnonzero(alpha[2] > 200)
    assert abs(alpha.max() - PLANE) <= 0.5 and np.all(alpha == alpha[0])
    assert abs(lit.mean() - column) <= 1.0 and len(lit) <= 3
    far_from = abs(np.arange(240) - column) > 20
    assert alpha[2, far_from].max() == 0


def test_focus_plane_line_is_unbroken_at_any_f_stop(ctx, overlays):
    for f_stop in (0.7, 2.8, 11.0):
        lens = replace(LENS, f_stop=f_stop, focus_distance_m=2.0)
        alpha = draw_overlay(overlays, ctx, "focus plane", ramp_plate(), lens)[..., 3]
        assert abs(alpha[:, 147:152].max(axis=1).min() - PLANE) <= 0.5, f_stop


def test_focus_plane_overlay_ignores_depth_steps_across_focus(ctx, overlays):
    coc = np.where(np.arange(20) < 10, -12.0, 12.0) * np.ones((4, 1))
    plate = coc_plate_of(np.zeros((4, 20, 3), np.float32), coc)
    assert draw_overlay(overlays, ctx, "focus plane", plate)[..., 3].max() == 0


@pytest.mark.parametrize("size", [(1, 1), (1, 200), (301, 7)])
@pytest.mark.parametrize("overlay", [it.name for it in OVERLAYS])
def test_overlay_covers_picture_of_any_size(ctx, overlays, size, overlay):
    plate = plate_of(np.zeros((size[1], size[0], 3), np.float32), np.full(size[::-1], 2.0))
    found = draw_overlay(overlays, ctx, overlay, plate)
    assert np.all(found == found[0, 0]) and found[0, 0, 3] > 0


@pytest.mark.parametrize("stops", [0.25, 1.0])
def test_peaking_marks_contrast_only_in_focus(ctx, overlays, stops):
    """Compare a flat wall in focus with the same formula in NumPy; out of focus nothing shows."""
    light = np.random.default_rng(1).uniform(0.01, 1.0, (9, 13, 3)).astype(np.float32)
    plate = plate_of(light, np.full((9, 13), 2.0))
    log = np.log2(light @ np.array([0.2126, 0.7152, 0.0722]) + 0.002)
    padded = np.pad(log, 1, mode="edge")
    across = padded[1:-1, 2:] - padded[1:-1, :-2]
    edge = np.hypot(across, padded[2:, 1:-1] - padded[:-2, 1:-1])
    part = np.clip(edge / stops - 1.0, 0.0, 1.0)
    expected = part * part * (3.0 - 2.0 * part)
    peaking = Peaking(stops=stops)
    found = draw_overlay(overlays, ctx, "none", plate, LENS, peaking=peaking)
    np.testing.assert_allclose(found[..., 3] / 255, expected, atol=0.01)
    blurred = replace(LENS, focus_distance_m=0.5)
    assert not draw_overlay(overlays, ctx, "none", plate, blurred, peaking=peaking)[..., 3].any()


def test_peaking_on_depth_marks_pixels_up_to_its_blur(ctx, overlays):
    depth = np.broadcast_to(np.linspace(1.5, 3.0, 40, dtype=np.float32), (5, 40))
    plate = plate_of(np.full((5, 40, 3), 0.5, np.float32), depth)
    coc, sharp = np.abs(coc_of(plate)), sharp_px(LENS, 40)
    for blur in (0.5, 1.0, 3.0):
        peaking = Peaking(PeakingOn.DEPTH, blur=blur)
        found = draw_overlay(overlays, ctx, "none", plate, peaking=peaking)[..., 3] / 255
        far = np.abs(coc - blur * sharp) > 1e-4
        np.testing.assert_array_equal((found > 0)[far], (coc < blur * sharp)[far])
        inside = (coc < blur * sharp) & far
        np.testing.assert_allclose(
            found[inside], (0.7 - 0.4 * coc / (blur * sharp))[inside], atol=0.01
        )
    assert not draw_overlay(overlays, ctx, "none", plate, peaking=USUAL_PEAKING)[
        ..., 3
    ].any()  # there is no edge


@pytest.mark.parametrize("name", PEAKING_COLORS)
def test_peaking_uses_chosen_color(ctx, overlays, name):
    found = draw_overlay(overlays, ctx, "none", room_plate(), peaking=Peaking(color=name))
    colors = found[found[..., 3] > 0][:, :3]
    assert len(colors)
    np.testing.assert_allclose(colors / 255, [PEAKING_COLORS[name]] * len(colors), atol=0.005)


def test_peaking_finds_edges_of_given_picture(ctx, overlays):
    """Check a picture smaller than the plate: its edge is marked, a soft ramp has no edges."""
    plate = plate_of(np.full((32, 48, 3), 0.2, np.float32), np.full((32, 48), 2.0))
    light = np.full((16, 24, 3), 0.1, np.float32)
    light[:, 12:] = 0.8
    found = draw_overlay(overlays, ctx, "none", plate, peaking=USUAL_PEAKING, light=light)[..., 3]
    assert set(np.flatnonzero(found[10])) == {22, 23, 24, 25}
    soft = np.broadcast_to(np.geomspace(0.1, 0.8, 24, dtype=np.float32)[None, :, None], (16, 24, 3))
    assert not draw_overlay(overlays, ctx, "none", plate, peaking=USUAL_PEAKING, light=soft)[
        ..., 3
    ].any()


@PLATES
@pytest.mark.parametrize("overlay", list(overlays_by_name()))
def test_peaking_is_composited_over_any_overlay(ctx, overlays, make, overlay):
    """Check over a grey picture that both drawn together equal overlay, then peaking, on top."""
    plate, grey = make(), np.full(3, 100.0)
    peaking = Peaking(PeakingOn.DEPTH, blur=2.0)
    base, peaks, both = (
        draw_overlay(overlays, ctx, *of[:1], plate, peaking=of[1]).astype(float)
        for of in ((overlay, None), ("none", peaking), (overlay, peaking))
    )
    assert (peaks[..., 3] > 0).any() and (peaks[..., 3] == 0).any()

    def over(picture: np.ndarray, colors: np.ndarray) -> np.ndarray:
        alpha = colors[..., 3:] / 255
        return picture * (1 - alpha) + colors[..., :3] * alpha

    np.testing.assert_allclose(over(grey, both), over(over(grey, base), peaks), atol=1.6)
