"""Window coordinates and picture coordinates, and zooming and panning between them.

window     where ImGui and the pointer are: units of the window, y down
picture    pixels of the display window counted from its corner, y down; a pixel's center is at .5
screen     physical pixels: `framebuffer_scale` of them are one window unit
"""

import math
from dataclasses import dataclass, replace

from heatlens.core.model.shot.camera_track import Vector
from heatlens.core.model.view.view import ZOOM_LEAST, ZOOM_MOST, ViewState

Point = tuple[float, float]
Pixel = tuple[int, int]


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


def desqueezed_shape(view: ViewState, shape: PictureShape) -> PictureShape:
    """Return the shape with the pixel width that the view's desqueeze sets."""
    aspect = view.guides.desqueeze
    return shape if aspect is None else replace(shape, pixel_aspect=aspect)


def geometry(view: ViewState, viewport: Viewport, shape: PictureShape) -> ViewGeometry:
    """Return the position and the scale of the picture in the window.

    Its corner is on a whole screen pixel, so that 1:1 is sharp.
    """
    shape = desqueezed_shape(view, shape)
    zoom = view.zoom or fit_zoom(viewport, shape)
    scale = viewport.framebuffer_scale
    per_px = (zoom * shape.pixel_aspect / scale, zoom / scale)
    center = view.center_px or shape.middle_px
    middle = viewport.middle
    origin = [
        viewport_middle - picture_center * scale_per_px
        for viewport_middle, picture_center, scale_per_px in zip(
            middle, center, per_px, strict=True
        )
    ]
    return ViewGeometry(
        (_snap_to_screen_pixel(origin[0], scale), _snap_to_screen_pixel(origin[1], scale)), per_px
    )


def _snap_to_screen_pixel(position: float, scale: float) -> float:
    """Return the window position on the nearest whole pixel of the screen."""
    return round(position * scale) / scale


def zoom_view(
    view: ViewState, viewport: Viewport, shape: PictureShape, factor: float, window_point: Point
) -> ViewState:
    """Return the view zoomed by `factor`; the picture point at `window_point` stays there."""
    current_zoom = view.zoom or fit_zoom(viewport, desqueezed_shape(view, shape))
    return zoom_view_to(view, viewport, shape, current_zoom * factor, window_point)


def zoom_view_to(
    view: ViewState, viewport: Viewport, shape: PictureShape, zoom: float, window_point: Point
) -> ViewState:
    """Return the view at `zoom` screen pixels a pixel; the point at `window_point` stays there."""
    fixed_point = geometry(view, viewport, shape).picture_at_window(window_point)
    shape = desqueezed_shape(view, shape)
    zoom = min(max(zoom, ZOOM_LEAST), ZOOM_MOST)
    per_px = (
        zoom * shape.pixel_aspect / viewport.framebuffer_scale,
        zoom / viewport.framebuffer_scale,
    )
    middle = viewport.middle
    center = (
        fixed_point[0] - (window_point[0] - middle[0]) / per_px[0],
        fixed_point[1] - (window_point[1] - middle[1]) / per_px[1],
    )
    return replace(view, zoom=zoom, center_px=center)


def pan_view(view: ViewState, viewport: Viewport, shape: PictureShape, offset: Point) -> ViewState:
    """Return the view with the picture moved by `offset` window units.

    A picture that fits the viewport keeps its size.

    The center of the viewport stays over the picture, or moves no farther from it if zooming at the
    pointer has left it outside.
    """
    shape = desqueezed_shape(view, shape)
    zoom = view.zoom or fit_zoom(viewport, shape)
    x, y = view.center_px or shape.middle_px
    scale = viewport.framebuffer_scale
    center = (
        _pan_axis(x, offset[0] * scale / (zoom * shape.pixel_aspect), shape.width_px),
        _pan_axis(y, offset[1] * scale / zoom, shape.height_px),
    )
    return replace(view, zoom=zoom, center_px=center)


def _pan_axis(center_px: float, by_px: float, size_px: int) -> float:
    """Return the center moved by `by_px` along one axis, within the picture of `size_px`."""
    least, most = min(center_px, 0.0), max(center_px, float(size_px))
    return min(max(center_px - by_px, least), most)


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """A pinhole camera: its lens, and the shape of its picture."""

    focal_length_mm: float
    sensor_width_mm: float
    shape: PictureShape

    def point_m(self, pixel: tuple[int, int], depth_m: float) -> Vector:
        """Return where the middle of a pixel lies: right of, below and in front of the camera.

        `depth_m` is measured along the axis. The sensor is as wide as the picture.
        """
        pitch_x = self.sensor_width_mm / self.shape.width_px / self.focal_length_mm
        pitch_y = pitch_x / self.shape.pixel_aspect
        middle_x, middle_y = self.shape.middle_px
        across = (pixel[0] + 0.5 - middle_x) * pitch_x
        down = (pixel[1] + 0.5 - middle_y) * pitch_y
        return across * depth_m, down * depth_m, depth_m
