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

from heatlens.core.base.outside_text import printable
from heatlens.core.model.lens import opening
from heatlens.core.model.lens.aperture import APERTURE_FIELDS, LEAN_FIELDS, LEAN_TERMS, Aperture
from heatlens.core.model.lens.disc_shape import DiscShape, PictureField
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.lens.opening_fields import BLADES_LEAST, BLADES_MOST
from heatlens.core.model.option import options_of
from heatlens.studio.session.messages import reported
from heatlens.studio.ui import probe, theme, widgets
from heatlens.studio.ui.field_row import field_row
from heatlens.studio.ui.panels.lens_panel import parse_stop

_SIDE_EM, _ROUNDING_EM = 5.5, 0.2  # size of a drawing
_CORNERS = 96  # corners of the drawn outline
_RINGS = 14  # rings of equal brightness that make up a disc
_BRIGHTEST = 2.2  # brightness drawn as white, relative to the mean of the disc
_SHAPE = (1600, 900)  # size of the picture whose corner is shown
_CELLS = 64  # cells of the drawing of an aperture image, in each direction
_GREYS = 32
_TOLD = options_of(Lens)
_DRAWN_ELSEWHERE = {
    *("squeeze", "blades", "blade_rotation_deg", "blade_curvature", "aperture_image"),
    *LEAN_FIELDS,
}

Points = NDArray[np.float64]
Say = Callable[[str], None]


def opening_panel(lens: Lens, say: Say, ask_image: Callable[[], None]) -> Lens:
    """Draw the controls of the aperture's shape; return the lens as the user left it.

    `ask_image` opens the dialog for a picture that replaces the blades.
    """
    with reported(say):  # a change that gives an impossible lens is discarded
        return _leaning(_opening(lens, say, ask_image))
    return lens


def _leaning(lens: Lens) -> Lens:
    is_leaning = any(getattr(lens, term) for term in LEAN_TERMS)
    flags = imgui.TreeNodeFlags_.default_open if is_leaning else 0
    is_open = imgui.collapsing_header("Tilt and split diopter", flags)
    probe.note("tilt and split diopter")
    for name in LEAN_FIELDS if is_open else ():
        term = _TOLD[name].term  # without it the others have no effect
        with widgets.disabled(name != term and not getattr(lens, term)):
            lens = field_row(lens, name)
    return lens


def _opening(lens: Lens, say: Say, ask_image: Callable[[], None]) -> Lens:
    flags = 0 if lens.aperture.is_plain else imgui.TreeNodeFlags_.default_open
    is_open = imgui.collapsing_header("Opening", flags)
    probe.note("opening")
    if not is_open:
        return lens
    _drawings(lens.aperture)
    lens = _blades(_image(lens, ask_image))
    for name in APERTURE_FIELDS:
        if name not in _DRAWN_ELSEWHERE:
            lens = field_row(lens, name)
    return _widest(lens, say)


def _image(lens: Lens, ask: Callable[[], None]) -> Lens:
    """Draw the name of the aperture image, with buttons to choose another one or none."""
    image = lens.aperture_image
    widgets.label(_TOLD["aperture_image"].label, _TOLD["aperture_image"].tip)
    is_taken_off = False
    if image is not None:
        tip = "Remove the image and use the blades again."
        is_taken_off = widgets.small_button("x##no aperture image", "no aperture image", tip)
        imgui.same_line()
    words = "Choose..." if image is None else f"{printable(Path(image.path).name)}##image"
    tip = "Choose a picture." if image is None else image.path
    if widgets.button(words, "aperture image", tip):
        ask()
    return replace(lens, aperture_image=None) if is_taken_off else lens


def _blades(lens: Lens) -> Lens:
    has_image = lens.aperture_image is not None
    words = {0: "round"} | {n: str(n) for n in range(BLADES_LEAST, BLADES_MOST + 1)}
    with widgets.disabled(has_image):
        lens = replace(lens, blades=widgets.pick("blades", lens.blades, words))
    with widgets.disabled(lens.blades == 0 and not has_image):
        lens = field_row(lens, "blade_rotation_deg")
    with widgets.disabled(lens.blades == 0 or has_image):
        return field_row(lens, "blade_curvature")


def _widest(lens: Lens, say: Say) -> Lens:
    """Draw the f-stop at which the barrel causes the full cat's eye."""
    if lens.cat_eye == 0.0:
        return lens
    widgets.label("at f-stop", "The widest f-stop of the lens: stopped down, the barrel cuts less.")
    shown = "" if lens.widest_f_stop is None else f"f/{lens.widest_f_stop:.4g}"
    now, parse = lens.widest_f_stop, widgets.optional(parse_stop)
    widest = widgets.text_field("at f-stop", shown, now, parse, say, "every f-stop")
    return replace(lens, widest_f_stop=widest)


def _drawings(aperture: Aperture) -> None:
    """Draw the disc at the middle of the picture, and beside it the disc at the upper right."""
    side = _SIDE_EM * imgui.get_font_size()
    places = {"middle": (_SHAPE[0] / 2, _SHAPE[1] / 2)}
    if aperture.cat_eye:
        places["corner, upper right"] = (float(_SHAPE[0]), 0.0)
    for words, place in places.items():
        imgui.begin_group()
        at = imgui.get_cursor_screen_pos()
        imgui.dummy(ImVec2(side, side))
        end, rounding = ImVec2(at.x + side, at.y + side), _ROUNDING_EM * imgui.get_font_size()
        ground = theme.colors.disc_ground
        imgui.get_window_draw_list().add_rect_filled(at, end, ground, rounding)
        _disc(aperture, place, (at.x + side / 2, at.y + side / 2), side / 2)
        imgui.text_disabled(words)
        imgui.end_group()
        imgui.same_line()
    imgui.new_line()


def disc_outline(aperture: Aperture, place: tuple[float, float], within: float = 1.0) -> Points:
    """Return the (n, 2) outline of a disc behind the focus, in radii, x right and y down.

    `place` is the position in a picture of size `_SHAPE`. `within` scales the opening about its
    middle, for the inner rings.
    """
    angle = np.linspace(0.0, 2 * math.pi, _CORNERS, endpoint=False)
    blades = aperture.diaphragm
    if blades.number:  # include the corners of the blades among the points
        corners = blades.turn + 2 * math.pi * np.arange(blades.number) / blades.number
        angle = np.sort(np.concatenate([angle, np.mod(corners, 2 * math.pi)]))
    barrel = PictureField.of(_SHAPE).barrel(aperture, place)
    reach = np.minimum(opening.rim_radius(angle, blades, barrel), within)
    across, up = aperture.half_extents
    return np.stack([across * reach * np.cos(angle), -up * reach * np.sin(angle)], axis=1)


def _disc(
    aperture: Aperture, place: tuple[float, float], centre: tuple[float, float], radius_px: float
) -> None:
    """Draw the disc as rings whose brightness follows the rim, coloured by axial colour."""
    if aperture.aperture_image is not None:
        _image_disc(aperture, place, centre, radius_px)
        return
    draw = imgui.get_window_draw_list()
    for part in np.linspace(1.0, 1 / _RINGS, _RINGS):
        shown = float(opening.profile((part - 0.5 / _RINGS) ** 2, aperture.rim))
        grey = min(shown / _BRIGHTEST, 1.0) ** (1 / 2.2)
        color = theme.packed((grey, grey, grey))
        ring = disc_outline(aperture, place, part)
        draw.add_convex_poly_filled([*_on_screen(ring, centre, radius_px)], color)
    if aperture.axial_colour_mm:
        wider, narrower = (theme.colors.fringe_blue, theme.colors.fringe_red)
        if aperture.axial_colour_mm < 0:
            wider, narrower = narrower, wider
        for scale, line in ((0.97, narrower), (1.0, wider)):
            points = _on_screen(scale * disc_outline(aperture, place), centre, radius_px)
            draw.add_polyline([*points], line, 1.5, imgui.ImDrawFlags_.closed)


def _image_disc(
    aperture: Aperture, place: tuple[float, float], centre: tuple[float, float], radius_px: float
) -> None:
    """Draw the light of an aperture image as small squares; the brightest is white."""
    draw, step = imgui.get_window_draw_list(), 2 * radius_px / _CELLS
    left, top = centre[0] - radius_px, centre[1] - radius_px
    draw.add_rect_filled(
        ImVec2(left, top),
        ImVec2(left + 2 * radius_px, top + 2 * radius_px),
        theme.OVER_PICTURE.groove,
    )
    for row, line in enumerate(image_cells(aperture, place)):
        for first, last, grey in line:
            color = theme.packed((grey, grey, grey))
            # Align squares to screen pixels, or gaps would show between them.
            corner = ImVec2(round(left + first * step), round(top + row * step))
            end = ImVec2(round(left + last * step), round(top + (row + 1) * step))
            draw.add_rect_filled(corner, end, color)


@lru_cache(maxsize=8)
def image_cells(
    aperture: Aperture, place: tuple[float, float]
) -> tuple[tuple[tuple[int, int, float], ...], ...]:
    """Return the rows of a disc behind the focus as runs of cells: (first, after the last, grey).

    The box around a round disc has `_CELLS` cells in each direction; black runs are left out.
    """
    disc = DiscShape(aperture, 1.0, PictureField.of(_SHAPE))
    y, x = np.mgrid[0:_CELLS, 0:_CELLS] + 0.5 - _CELLS / 2
    shown = disc.coverage(x, y, _CELLS / 2, 0.5, place)
    greys = np.round(_GREYS * (shown / shown.max()) ** (1 / 2.2)).astype(int)
    return tuple(tuple(_runs(row)) for row in greys)


def _runs(row: NDArray[np.int_]) -> Iterator[tuple[int, int, float]]:
    ends = [0, *(np.flatnonzero(np.diff(row)) + 1).tolist(), len(row)]
    for first, last in pairwise(ends):
        if row[first]:
            yield first, last, float(row[first]) / _GREYS


def _on_screen(points: Points, centre: tuple[float, float], radius_px: float) -> Iterator[ImVec2]:
    return (ImVec2(centre[0] + radius_px * x, centre[1] + radius_px * y) for x, y in points)
