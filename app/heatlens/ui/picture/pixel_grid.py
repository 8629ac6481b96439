"""Draw lines between pixels when zoomed in, and the outline of the display window."""

from imgui_bundle import ImVec2, imgui

from heatlens.model.view_geometry import PictureShape
from heatlens.session.pictures.picture_view import PictureView
from heatlens.ui import theme
from heatlens.ui.picture.pictures import Pictures

_GRID_FROM = 8.0  # smallest size of a pixel on the screen, in screen pixels, for the grid


def seen_pixels(place: PictureView, shape: PictureShape) -> tuple[int, int, int, int]:
    """Return the visible pixels, as half-open ranges of columns and rows."""
    (x, y), (width, height) = place.viewport.corner, place.viewport.size
    x0, y0 = place.geometry.pixel_at_window((x, y))
    x1, y1 = place.geometry.pixel_at_window((x + width, y + height))
    return max(x0, 0), max(y0, 0), min(x1 + 1, shape.width_px), min(y1 + 1, shape.height_px)


def draw_pixel_grid(place: PictureView, shape: PictureShape) -> None:
    """Draw the grid in the current window if the pixels are large enough."""
    if place.zoom < _GRID_FROM:
        return
    draw, at = imgui.get_window_draw_list(), place.geometry.window_at_picture
    x0, y0, x1, y1 = seen_pixels(place, shape)
    (left, top), (right, bottom) = at((x0, y0)), at((x1, y1))
    for x in range(x0, x1 + 1):
        line = at((x, 0))[0]
        draw.add_line(ImVec2(line, top), ImVec2(line, bottom), theme.OVER_PICTURE.pixel_grid)
    for y in range(y0, y1 + 1):
        line = at((0, y))[1]
        draw.add_line(ImVec2(left, line), ImVec2(right, line), theme.OVER_PICTURE.pixel_grid)


def draw_display_window(place: PictureView, pictures: Pictures) -> None:
    """Draw the outline of the display window if the data window differs from it."""
    if pictures.data_window == pictures.display_window:
        return
    window, at = pictures.display_window, place.geometry.window_at_picture
    first, last = ImVec2(*at((0, 0))), ImVec2(*at((window.width, window.height)))
    imgui.get_window_draw_list().add_rect(first, last, theme.OVER_PICTURE.window_line)
