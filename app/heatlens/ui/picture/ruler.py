"""Draw the ruler over the picture: its ends, the line between them, and the length."""

import math

from imgui_bundle import ImVec2, imgui

from heatlens.model.lens.lens import measured_text
from heatlens.model.units import format_distance
from heatlens.session.facts import Facts
from heatlens.session.pictures.picture_view import PictureView
from heatlens.session.pictures.ruler import Pixel, Ruler
from heatlens.ui import probe, theme

_END_EM, _LINE_EM = 0.3, 0.13
_HINT = "Ruler: click two points, or drag from one to the other. Escape ends it."


def draw_ruler(ruler: Ruler, view: PictureView, facts: Facts, hovered: Pixel | None) -> None:
    """Draw the ruler in the current window; with one end set it follows the pointer."""
    if not ruler.is_on:
        return
    _draw_hint(view)
    ends = _ends(ruler, hovered)
    at = [ImVec2(*view.geometry.window_at_picture((x + 0.5, y + 0.5))) for x, y in ends]
    draw, em = imgui.get_window_draw_list(), imgui.get_font_size()
    if len(at) == 2:
        draw.add_line(at[0], at[1], theme.OVER_PICTURE.shadow, 2.0 * _LINE_EM * em)
        draw.add_line(at[0], at[1], theme.OVER_PICTURE.handle, _LINE_EM * em)
    for end in at:
        draw.add_circle_filled(end, _END_EM * em, theme.OVER_PICTURE.shadow)
        draw.add_circle(end, _END_EM * em, theme.OVER_PICTURE.handle, 0, _LINE_EM * em)
    measured = ruler.measured(hovered) if len(at) == 2 else None
    if measured is None:
        return
    unit = facts.unit
    is_far = math.isinf(measured.distance_m) or math.isnan(measured.distance_m)
    words = "infinitely far" if is_far else format_distance(measured.distance_m, unit)
    for end, depth_m in zip(at, measured.depths_m, strict=True):
        _draw_label(
            end, f"at {measured_text(facts.lens, depth_m, unit)}", theme.OVER_PICTURE.handle, 1.2
        )
    _draw_label(
        ImVec2((at[0].x + at[1].x) / 2, (at[0].y + at[1].y) / 2),
        words,
        theme.OVER_PICTURE.handle,
        -1.2,
    )
    probe.note_at(f"ruler {words}", (at[0].x, at[0].y, at[1].x, at[1].y))


def _draw_hint(place: PictureView) -> None:
    """Draw at the upper edge of the viewport what the mouse does now."""
    viewport, em = place.viewport, imgui.get_font_size()
    (x, y), (width, _) = viewport.corner, viewport.size
    _draw_label(ImVec2(x + width / 2, y + em), _HINT, theme.OVER_PICTURE.handle, 0.3)


def _ends(ruler: Ruler, hovered: Pixel | None) -> tuple[Pixel, ...]:
    if len(ruler.points) != 1 or hovered is None or not ruler.is_inside(hovered):
        return ruler.points  # a line to a place beside the picture would have no length
    return (*ruler.points, hovered)


def _draw_label(at: ImVec2, words: str, color: int, below_em: float) -> None:
    """Draw text on a dark background, so many em below a point."""
    em, wide = imgui.get_font_size(), imgui.calc_text_size(words)
    corner = ImVec2(at.x - wide.x / 2, at.y + below_em * em - wide.y / 2)
    draw = imgui.get_window_draw_list()
    first = ImVec2(corner.x - 0.3 * em, corner.y - 0.1 * em)
    last = ImVec2(corner.x + wide.x + 0.3 * em, corner.y + wide.y + 0.1 * em)
    draw.add_rect_filled(first, last, theme.OVER_PICTURE.shadow, 3.0)
    draw.add_text(corner, color, words)
