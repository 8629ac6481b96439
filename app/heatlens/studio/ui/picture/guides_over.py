"""Draw the guides over the picture, and the numbers of a count-in."""

from collections.abc import Iterator

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.view.guides import (
    NO_GUIDES,
    Guides,
    Rect,
    guide_shapes,
    inner_rect,
    lines_of,
)
from heatlens.core.model.view.view_geometry import PictureShape, Viewport
from heatlens.studio.session.pictures.picture_view import PictureView
from heatlens.studio.ui import probe, theme

_BEAT_EM = 8.0  # size of a number of the count-in


def draw_guides(
    guides: Guides, shape: PictureShape, place: PictureView, crop: float | None = None
) -> None:
    """Draw the guides over the picture at `place`, in the current window.

    `crop` is the share of the picture around its middle to frame.
    """
    if guides == NO_GUIDES and crop is None:
        return
    first = place.geometry.window_at_picture((0.0, 0.0))
    last = place.geometry.window_at_picture((shape.width_px, shape.height_px))
    picture = (*first, *last)
    lines = lines_of(guides.canvases, shape.width_px, shape.height_px)
    shapes = guide_shapes(guides, picture, lines)
    draw = imgui.get_window_draw_list()
    (x, y), (width, height) = place.viewport.corner, place.viewport.size
    draw.push_clip_rect(ImVec2(x, y), ImVec2(x + width, y + height), True)
    shade = theme.packed((0.0, 0.0, 0.0, guides.opacity))
    for rect in shapes.shades:
        draw.add_rect_filled(ImVec2(*rect[:2]), ImVec2(*rect[2:]), shade)
    for rect in (*shapes.frames, *_cropped(picture, crop)):
        draw.add_rect(ImVec2(*rect[:2]), ImVec2(*rect[2:]), theme.OVER_PICTURE.guide)
    _names(draw, [line.name for line in lines], shapes.frames)
    for line in shapes.lines:
        draw.add_line(ImVec2(*line[:2]), ImVec2(*line[2:]), theme.OVER_PICTURE.guide)
    draw.pop_clip_rect()
    probe.note_at("matte in the picture", inner_rect(picture, guides.aspect))


def _names(draw: imgui.ImDrawList, names: list[str], frames: tuple[Rect, ...]) -> None:
    """Write the names of the last frames into their lower left corners."""
    for name, (x0, y0, x1, y1) in zip(names, frames[len(frames) - len(names) :], strict=True):
        at = ImVec2(x0 + 4.0, y1 - 1.3 * imgui.get_font_size())
        draw.add_text(at, theme.OVER_PICTURE.guide, printable(name))
        probe.note_at(f"frame {name}", (x0, y0, x1, y1))


def _cropped(picture: Rect, share: float | None) -> Iterator[Rect]:
    """Yield the middle of a picture, if a share of its sides is given."""
    if share is not None:
        x, y = (picture[0] + picture[2]) / 2, (picture[1] + picture[3]) / 2
        across, down = share * (picture[2] - x), share * (picture[3] - y)
        yield x - across, y - down, x + across, y + down
        probe.note_at("crop of the plate", (x - across, y - down, x + across, y + down))


def draw_beat(number: int, place: Viewport) -> None:
    """Draw a number of the count-in over the middle of the picture."""
    font, size, text = imgui.get_font(), _BEAT_EM * imgui.get_font_size(), str(number)
    half = imgui.calc_text_size(text).x * _BEAT_EM / 2
    (x, y), (width, height) = place.corner, place.size
    at = ImVec2(x + width / 2 - half, y + (height - size) / 2)
    draw, edge = imgui.get_window_draw_list(), 0.02 * size
    shadow = ImVec2(at.x + edge, at.y + edge)
    draw.add_text(font, size, shadow, theme.OVER_PICTURE.shadow, text)
    draw.add_text(font, size, at, theme.OVER_PICTURE.handle, text)
    probe.note_at(f"beat {text}", (at.x, at.y, at.x + 2 * half, at.y + size))
