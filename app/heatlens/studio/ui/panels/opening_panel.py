"""Draw the controls of the aperture's shape, and its disc as a highlight would show it."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import numpy as np
from imgui_bundle import ImVec2, imgui
from numpy.typing import NDArray

from heatlens.core.base.messages import report_errors
from heatlens.core.base.outside_text import printable
from heatlens.core.model.lens import opening
from heatlens.core.model.lens.aperture import (
    APERTURE_FIELDS,
    FOCUS_OFFSET_FIELDS,
    FOCUS_OFFSET_TERMS,
    Aperture,
)
from heatlens.core.model.lens.disc_shape import DiscShape, PictureField
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.lens.opening_fields import BLADES_LEAST, BLADES_MOST
from heatlens.core.model.option import options_of
from heatlens.studio.ui import rects, theme, widgets
from heatlens.studio.ui.field_row import field_row
from heatlens.studio.ui.panels.lens_panel import parse_stop

_SIDE_EM, _ROUNDING_EM = 5.5, 0.2  # size of a drawing
_CORNERS = 96  # corners of the drawn outline
_RINGS = 14  # rings of equal brightness that make up a disc
_BRIGHTEST = 2.2  # brightness drawn as white, relative to the mean of the disc
_SHAPE = (1600, 900)  # size of the picture whose corner is shown
_CELLS = 64  # cells of the drawing of an aperture image, in each direction
_GRAY_LEVELS = 32
_LENS_OPTIONS = options_of(Lens)
_OWN_ROWS = {
    *("squeeze", "blades", "blade_rotation_deg", "blade_curvature", "aperture_image"),
    *FOCUS_OFFSET_FIELDS,
}

Points = NDArray[np.float64]
Notify = Callable[[str], None]


def opening_panel(lens: Lens, notify: Notify, ask_image: Callable[[], None]) -> Lens:
    """Draw the controls of the aperture's shape; return the lens as the user left it.

    `ask_image` opens the dialog for a picture that replaces the blades.
    """
    with report_errors(notify):  # a change that gives an impossible lens is discarded
        return _tilt_rows(_opening_rows(lens, notify, ask_image))
    return lens


def _tilt_rows(lens: Lens) -> Lens:
    """Draw the rows of tilt and split diopter, folded unless they are used."""
    is_tilted = any(getattr(lens, term) for term in FOCUS_OFFSET_TERMS)
    flags = imgui.TreeNodeFlags_.default_open if is_tilted else 0
    is_open = imgui.collapsing_header("Tilt and split diopter", flags)
    rects.note("tilt and split diopter")
    for name in FOCUS_OFFSET_FIELDS if is_open else ():
        term = _LENS_OPTIONS[name].term  # the field without which this one has no effect
        with widgets.disabled(name != term and not getattr(lens, term)):
            lens = field_row(lens, name)
    return lens


def _opening_rows(lens: Lens, notify: Notify, ask_image: Callable[[], None]) -> Lens:
    """Draw the rows of the aperture's shape, folded unless it has one."""
    flags = 0 if lens.aperture.is_plain else imgui.TreeNodeFlags_.default_open
    is_open = imgui.collapsing_header("Opening", flags)
    rects.note("opening")
    if not is_open:
        return lens
    _draw_discs(lens.aperture)
    lens = _blade_rows(_image_row(lens, ask_image))
    for name in APERTURE_FIELDS:
        if name not in _OWN_ROWS:
            lens = field_row(lens, name)
    return _widest_f_stop_row(lens, notify)


def _image_row(lens: Lens, ask: Callable[[], None]) -> Lens:
    """Draw the name of the aperture image, with buttons to choose another one or none."""
    image = lens.aperture_image
    widgets.label(_LENS_OPTIONS["aperture_image"].label, _LENS_OPTIONS["aperture_image"].tip)
    is_removed = False
    if image is not None:
        tip = "Remove the image and use the blades again."
        is_removed = widgets.small_button("x##no aperture image", "no aperture image", tip)
        imgui.same_line()
    words = "Choose..." if image is None else f"{printable(Path(image.path).name)}##image"
    tip = "Choose a picture." if image is None else image.path
    if widgets.button(words, "aperture image", tip):
        ask()
    return replace(lens, aperture_image=None) if is_removed else lens


def _blade_rows(lens: Lens) -> Lens:
    """Draw number, rotation and curvature of the blades."""
    has_image = lens.aperture_image is not None
    words = {0: "round"} | {number: str(number) for number in range(BLADES_LEAST, BLADES_MOST + 1)}
    with widgets.disabled(has_image):
        lens = replace(lens, blades=widgets.pick("blades", lens.blades, words))
    with widgets.disabled(lens.blades == 0 and not has_image):
        lens = field_row(lens, "blade_rotation_deg")
    with widgets.disabled(lens.blades == 0 or has_image):
        return field_row(lens, "blade_curvature")


def _widest_f_stop_row(lens: Lens, notify: Notify) -> Lens:
    """Draw the f-stop at which the barrel causes the full cat's eye."""
    if lens.cat_eye == 0.0:
        return lens
    widgets.label("at f-stop", "The widest f-stop of the lens: stopped down, the barrel cuts less.")
    widest_text = "" if lens.widest_f_stop is None else f"f/{lens.widest_f_stop:.4g}"
    old_widest, parse = lens.widest_f_stop, widgets.optional(parse_stop)
    new_widest = widgets.text_field(
        "at f-stop", widest_text, old_widest, parse, notify, "every f-stop"
    )
    return replace(lens, widest_f_stop=new_widest)


def _draw_discs(aperture: Aperture) -> None:
    """Draw the disc at the middle of the picture, and beside it the disc at the upper right."""
    side = _SIDE_EM * imgui.get_font_size()
    positions = {"middle": (_SHAPE[0] / 2, _SHAPE[1] / 2)}
    if aperture.cat_eye:
        positions["corner, upper right"] = (float(_SHAPE[0]), 0.0)
    for words, position in positions.items():
        imgui.begin_group()
        corner = imgui.get_cursor_screen_pos()
        imgui.dummy(ImVec2(side, side))
        end = ImVec2(corner.x + side, corner.y + side)
        rounding = _ROUNDING_EM * imgui.get_font_size()
        background = theme.colors.disc_ground
        imgui.get_window_draw_list().add_rect_filled(corner, end, background, rounding)
        _draw_disc(aperture, position, (corner.x + side / 2, corner.y + side / 2), side / 2)
        imgui.text_disabled(words)
        imgui.end_group()
        imgui.same_line()
    imgui.new_line()


def disc_outline(aperture: Aperture, position: tuple[float, float], scale: float = 1.0) -> Points:
    """Return the (n, 2) outline of a disc behind the focus, in radii, x right and y down.

    `position` is in pixels of a picture of size `_SHAPE`. `scale` shrinks the opening about its
    middle, for the inner rings.
    """
    angle = np.linspace(0.0, 2 * math.pi, _CORNERS, endpoint=False)
    blades = aperture.diaphragm
    if blades.number:  # include the corners of the blades among the points
        corners = blades.turn + 2 * math.pi * np.arange(blades.number) / blades.number
        angle = np.sort(np.concatenate([angle, np.mod(corners, 2 * math.pi)]))
    barrel = PictureField.of(_SHAPE).barrel(aperture, position)
    reach = np.minimum(opening.rim_radius(angle, blades, barrel), scale)
    across, up = aperture.half_extents
    return np.stack([across * reach * np.cos(angle), -up * reach * np.sin(angle)], axis=1)


def _draw_disc(
    aperture: Aperture, position: tuple[float, float], center: tuple[float, float], radius_px: float
) -> None:
    """Draw the disc as rings with the brightness of its profile, and the fringe of axial color."""
    if aperture.aperture_image is not None:
        _draw_image_disc(aperture, position, center, radius_px)
        return
    draw = imgui.get_window_draw_list()
    for ring_scale in np.linspace(1.0, 1 / _RINGS, _RINGS):
        brightness = float(opening.profile((ring_scale - 0.5 / _RINGS) ** 2, aperture.rim))
        gray = min(brightness / _BRIGHTEST, 1.0) ** (1 / 2.2)
        color = theme.pack_color((gray, gray, gray))
        ring = disc_outline(aperture, position, ring_scale)
        draw.add_convex_poly_filled([*_to_screen(ring, center, radius_px)], color)
    if aperture.axial_colour_mm:
        wider, narrower = (theme.colors.fringe_blue, theme.colors.fringe_red)
        if aperture.axial_colour_mm < 0:
            wider, narrower = narrower, wider
        for scale, line in ((0.97, narrower), (1.0, wider)):
            points = _to_screen(scale * disc_outline(aperture, position), center, radius_px)
            draw.add_polyline([*points], line, 1.5, imgui.ImDrawFlags_.closed)


def _draw_image_disc(
    aperture: Aperture, position: tuple[float, float], center: tuple[float, float], radius_px: float
) -> None:
    """Draw the light of an aperture image as small squares; the brightest is white."""
    draw, step = imgui.get_window_draw_list(), 2 * radius_px / _CELLS
    left, top = center[0] - radius_px, center[1] - radius_px
    draw.add_rect_filled(
        ImVec2(left, top),
        ImVec2(left + 2 * radius_px, top + 2 * radius_px),
        theme.OVER_PICTURE.groove,
    )
    for row, line in enumerate(image_cells(aperture, position)):
        for first, last, gray in line:
            color = theme.pack_color((gray, gray, gray))
            # Align squares to screen pixels, or gaps would show between them.
            corner = ImVec2(round(left + first * step), round(top + row * step))
            end = ImVec2(round(left + last * step), round(top + (row + 1) * step))
            draw.add_rect_filled(corner, end, color)


@lru_cache(maxsize=8)
def image_cells(
    aperture: Aperture, position: tuple[float, float]
) -> tuple[tuple[tuple[int, int, float], ...], ...]:
    """Return the rows of a disc behind the focus as runs of cells: (first, after the last, gray).

    The box around a round disc has `_CELLS` cells in each direction; black runs are omitted.
    """
    disc = DiscShape(aperture, pixel_aspect_ratio=1.0, in_picture=PictureField.of(_SHAPE))
    y, x = np.mgrid[0:_CELLS, 0:_CELLS] + 0.5 - _CELLS / 2
    light = disc.coverage(x, y, _CELLS / 2, 0.5, position)
    gray_levels = np.round(_GRAY_LEVELS * (light / light.max()) ** (1 / 2.2)).astype(int)
    return tuple(tuple(_gray_runs(row)) for row in gray_levels)


def _gray_runs(row: NDArray[np.int_]) -> Iterator[tuple[int, int, float]]:
    """Yield the runs of equal cells in a row that are not black."""
    ends = [0, *(np.flatnonzero(np.diff(row)) + 1).tolist(), len(row)]
    for first, last in pairwise(ends):
        if row[first]:
            yield first, last, float(row[first]) / _GRAY_LEVELS


def _to_screen(points: Points, center: tuple[float, float], radius_px: float) -> Iterator[ImVec2]:
    return (ImVec2(center[0] + radius_px * x, center[1] + radius_px * y) for x, y in points)
