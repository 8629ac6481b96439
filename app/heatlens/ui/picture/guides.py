"""Mattes and guide lines, drawn over the picture in the current window."""

from imgui_bundle import ImVec2, imgui

from heatlens.model.guides import (
    ACTION_SAFE,
    NO_GUIDES,
    TITLE_SAFE,
    Guides,
    Rect,
    inner_rect,
    scaled_rect,
)
from heatlens.model.view_geometry import PictureShape
from heatlens.session.picture_view import PictureView
from heatlens.ui import probe, theme

_CROSS_EM = 1.2


def draw_guides(guides: Guides, shape: PictureShape, place: PictureView) -> None:
    """Draw what is wished over the picture, which lies as `place` says."""
    if guides == NO_GUIDES:
        return
    geometry = place.geometry
    first = geometry.window_at_picture((0.0, 0.0))
    last = geometry.window_at_picture((shape.width_px, shape.height_px))
    picture = (*first, *last)
    inner = inner_rect(picture, guides.aspect)
    draw = imgui.get_window_draw_list()
    (x, y), (width, height) = place.viewport.corner, place.viewport.size
    draw.push_clip_rect(ImVec2(x, y), ImVec2(x + width, y + height), True)
    _draw_matte(draw, picture, inner)
    probe.note_at("matte in the picture", inner)
    if guides.safe_areas:
        for part in (ACTION_SAFE, TITLE_SAFE):
            _draw_rect(draw, scaled_rect(inner, part, part))
    if guides.thirds:
        _draw_thirds(draw, inner)
    if guides.centre:
        _draw_cross(draw, inner)
    draw.pop_clip_rect()


def _draw_matte(draw: imgui.ImDrawList, picture: Rect, inner: Rect) -> None:
    x0, y0, x1, y1 = picture
    a0, b0, a1, b1 = inner
    for rect in ((x0, y0, x1, b0), (x0, b1, x1, y1), (x0, b0, a0, b1), (a1, b0, x1, b1)):
        if rect[2] - rect[0] > 0 and rect[3] - rect[1] > 0:
            draw.add_rect_filled(ImVec2(*rect[:2]), ImVec2(*rect[2:]), theme.MATTE)
    if inner != picture:
        _draw_rect(draw, inner)


def _draw_rect(draw: imgui.ImDrawList, rect: Rect) -> None:
    draw.add_rect(ImVec2(*rect[:2]), ImVec2(*rect[2:]), theme.GUIDE)


def _draw_thirds(draw: imgui.ImDrawList, rect: Rect) -> None:
    x0, y0, x1, y1 = rect
    for part in (1 / 3, 2 / 3):
        x, y = x0 + part * (x1 - x0), y0 + part * (y1 - y0)
        draw.add_line(ImVec2(x, y0), ImVec2(x, y1), theme.GUIDE)
        draw.add_line(ImVec2(x0, y), ImVec2(x1, y), theme.GUIDE)


def _draw_cross(draw: imgui.ImDrawList, rect: Rect) -> None:
    x, y, reach = (
        (rect[0] + rect[2]) / 2,
        (rect[1] + rect[3]) / 2,
        _CROSS_EM * imgui.get_font_size(),
    )
    draw.add_line(ImVec2(x - reach, y), ImVec2(x + reach, y), theme.GUIDE, 1.5)
    draw.add_line(ImVec2(x, y - reach), ImVec2(x, y + reach), theme.GUIDE, 1.5)
