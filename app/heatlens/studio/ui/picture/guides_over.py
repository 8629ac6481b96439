"""Draw the guides over the picture, and the numbers of a count-in."""

from collections.abc import Iterator

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.view.guides import (
    NO_GUIDES,
    Guides,
    Rect,
    frame_lines_for,
    guide_shapes,
    inner_rect,
)
from heatlens.core.model.view.picture_view import PictureView
from heatlens.core.model.view.view_geometry import PictureShape, Viewport
from heatlens.studio.ui import rects, theme

_BEAT_EM = 8.0  # size of a number of the count-in


def draw_guides(
    guides: Guides, shape: PictureShape, picture_view: PictureView, crop: float | None = None
) -> None:
    """Draw the guides over the picture in `picture_view`, in the current window.

    `crop` is the share of the picture around its middle to frame.
    """
    if guides == NO_GUIDES and crop is None:
        return
    first = picture_view.geometry.window_at_picture((0.0, 0.0))
    last = picture_view.geometry.window_at_picture((shape.width_px, shape.height_px))
    picture = (*first, *last)
    lines = frame_lines_for(guides.canvases, shape.width_px, shape.height_px)
    shapes = guide_shapes(guides, picture, lines)
    draw = imgui.get_window_draw_list()
    (x, y), (width, height) = picture_view.viewport.corner, picture_view.viewport.size
    draw.push_clip_rect(ImVec2(x, y), ImVec2(x + width, y + height), True)
    shade = theme.pack_color((0.0, 0.0, 0.0, guides.opacity))
    for rect in shapes.shades:
        draw.add_rect_filled(ImVec2(*rect[:2]), ImVec2(*rect[2:]), shade)
    for rect in (*shapes.frames, *_crop_rect(picture, crop)):
        draw.add_rect(ImVec2(*rect[:2]), ImVec2(*rect[2:]), theme.OVER_PICTURE.guide)
    _draw_names(draw, [line.name for line in lines], shapes.frames)
    for line in shapes.lines:
        draw.add_line(ImVec2(*line[:2]), ImVec2(*line[2:]), theme.OVER_PICTURE.guide)
    draw.pop_clip_rect()
    rects.note_at("matte in the picture", inner_rect(picture, guides.aspect))


def _draw_names(draw: imgui.ImDrawList, names: list[str], frames: tuple[Rect, ...]) -> None:
    """Write the names of the last frames into their lower left corners."""
    for name, (x0, y0, x1, y1) in zip(names, frames[len(frames) - len(names) :], strict=True):
        text_corner = ImVec2(x0 + 4.0, y1 - 1.3 * imgui.get_font_size())
        draw.add_text(text_corner, theme.OVER_PICTURE.guide, printable(name))
        rects.note_at(f"frame {name}", (x0, y0, x1, y1))


def _crop_rect(picture: Rect, share: float | None) -> Iterator[Rect]:
    """Yield the rectangle in the middle of a picture with this share of its sides, unless None."""
    if share is not None:
        x, y = (picture[0] + picture[2]) / 2, (picture[1] + picture[3]) / 2
        half_width, half_height = share * (picture[2] - x), share * (picture[3] - y)
        yield x - half_width, y - half_height, x + half_width, y + half_height
        rects.note_at(
            "crop of the plate", (x - half_width, y - half_height, x + half_width, y + half_height)
        )


def draw_beat(number: int, viewport: Viewport) -> None:
    """Draw a number of the count-in over the middle of the picture."""
    font, size, text = imgui.get_font(), _BEAT_EM * imgui.get_font_size(), str(number)
    half_width = imgui.calc_text_size(text).x * _BEAT_EM / 2
    (x, y), (width, height) = viewport.corner, viewport.size
    text_corner = ImVec2(x + width / 2 - half_width, y + (height - size) / 2)
    draw, edge = imgui.get_window_draw_list(), 0.02 * size
    shadow = ImVec2(text_corner.x + edge, text_corner.y + edge)
    draw.add_text(font, size, shadow, theme.OVER_PICTURE.shadow, text)
    draw.add_text(font, size, text_corner, theme.OVER_PICTURE.handle, text)
    rects.note_at(
        f"beat {text}",
        (text_corner.x, text_corner.y, text_corner.x + 2 * half_width, text_corner.y + size),
    )
