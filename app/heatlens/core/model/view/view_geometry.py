"""Window coordinates and picture coordinates, and zooming and panning between them.

window     where ImGui and the pointer are: units of the window, y down
picture    pixels of the display window counted from its corner, y down; a pixel's centre is at .5
screen     physical pixels: `framebuffer_scale` of them are one window unit
"""

import math
from dataclasses import dataclass, replace

from heatlens.core.model.view.view import ZOOM_LEAST, ZOOM_MOST, ViewState

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Viewport:
    """The area in which pictures are shown: its corner and size in window units."""

    corner: Point
    size: Point
    framebuffer_scale: float = 1.0

    @property
    def middle(self) -> Point:
        """Its middle, as a window position."""
        (x, y), (width, height) = self.corner, self.size
        return x + width / 2, y + height / 2


@dataclass(frozen=True, slots=True)
class PictureShape:
    """A display window: its size in pixels, and the width of a pixel over its height."""

    width_px: int
    height_px: int
    pixel_aspect: float = 1.0

    @property
    def middle_px(self) -> Point:
        """The point in its middle."""
        return self.width_px / 2, self.height_px / 2


@dataclass(frozen=True, slots=True)
class ViewGeometry:
    """How picture points lie in the window."""

    origin: Point  # window position of the picture's corner
    per_px: Point  # window units for one pixel across and down

    def window_at_picture(self, point: Point) -> Point:
        """Return the window position of a picture point."""
        return (
            self.origin[0] + point[0] * self.per_px[0],
            self.origin[1] + point[1] * self.per_px[1],
        )

    def picture_at_window(self, point: Point) -> Point:
        """Return the picture point at a window position."""
        return (
            (point[0] - self.origin[0]) / self.per_px[0],
            (point[1] - self.origin[1]) / self.per_px[1],
        )

    def pixel_at_window(self, point: Point) -> tuple[int, int]:
        """Return the pixel at a window position; it may be outside the picture."""
        x, y = self.picture_at_window(point)
        return math.floor(x), math.floor(y)


def fit_zoom(viewport: Viewport, shape: PictureShape) -> float:
    """Return the zoom at which the whole picture is visible."""
    width, height = (side * viewport.framebuffer_scale for side in viewport.size)
    zoom = min(width / (shape.width_px * shape.pixel_aspect), height / shape.height_px)
    return min(max(zoom, ZOOM_LEAST), ZOOM_MOST)


def shown_shape(view: ViewState, shape: PictureShape) -> PictureShape:
    """Return the shape with the pixel width that the view's desqueeze sets."""
    aspect = view.guides.desqueeze
    return shape if aspect is None else replace(shape, pixel_aspect=aspect)


def geometry(view: ViewState, viewport: Viewport, shape: PictureShape) -> ViewGeometry:
    """Return where the picture lies.

    Its corner is on a whole screen pixel, so that 1:1 is sharp.
    """
    shape = shown_shape(view, shape)
    zoom = view.zoom or fit_zoom(viewport, shape)
    scale = viewport.framebuffer_scale
    per_px = (zoom * shape.pixel_aspect / scale, zoom / scale)
    center = view.center_px or shape.middle_px
    middle = viewport.middle
    origin = [m - c * p for m, c, p in zip(middle, center, per_px, strict=True)]
    return ViewGeometry((_whole(origin[0], scale), _whole(origin[1], scale)), per_px)


def _whole(position: float, scale: float) -> float:
    return round(position * scale) / scale


def zoomed(
    view: ViewState, viewport: Viewport, shape: PictureShape, factor: float, at: Point
) -> ViewState:
    """Zoom by `factor`; the picture point under the window position `at` stays there."""
    before = view.zoom or fit_zoom(viewport, shown_shape(view, shape))
    return zoomed_to(view, viewport, shape, before * factor, at)


def zoomed_to(
    view: ViewState, viewport: Viewport, shape: PictureShape, zoom: float, at: Point
) -> ViewState:
    """Zoom to `zoom` screen pixels a pixel; the picture point under `at` stays there."""
    held = geometry(view, viewport, shape).picture_at_window(at)
    shape = shown_shape(view, shape)
    zoom = min(max(zoom, ZOOM_LEAST), ZOOM_MOST)
    per_px = (
        zoom * shape.pixel_aspect / viewport.framebuffer_scale,
        zoom / viewport.framebuffer_scale,
    )
    middle = viewport.middle
    center = (
        held[0] - (at[0] - middle[0]) / per_px[0],
        held[1] - (at[1] - middle[1]) / per_px[1],
    )
    return replace(view, zoom=zoom, center_px=center)


def panned(view: ViewState, viewport: Viewport, shape: PictureShape, by: Point) -> ViewState:
    """Move the picture by so many window units; a fitting picture keeps its size.

    The centre of the viewport stays over the picture, or moves no farther from it if zooming at the
    pointer has left it outside.
    """
    shape = shown_shape(view, shape)
    zoom = view.zoom or fit_zoom(viewport, shape)
    x, y = view.center_px or shape.middle_px
    scale = viewport.framebuffer_scale
    center = (
        _panned(x, by[0] * scale / (zoom * shape.pixel_aspect), shape.width_px),
        _panned(y, by[1] * scale / zoom, shape.height_px),
    )
    return replace(view, zoom=zoom, center_px=center)


def _panned(center_px: float, by_px: float, size_px: int) -> float:
    least, most = min(center_px, 0.0), max(center_px, float(size_px))
    return min(max(center_px - by_px, least), most)
