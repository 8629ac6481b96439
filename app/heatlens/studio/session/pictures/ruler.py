"""Measure the distance in space between two points of the picture."""

import math
from dataclasses import dataclass

from heatlens.core.base.messages import report_errors
from heatlens.core.model.view.picture_view import PictureView
from heatlens.core.model.view.view_geometry import Intrinsics, Pixel, desqueezed_shape
from heatlens.media.plate.coc_line import depth_at_m
from heatlens.media.plate.plate import Plate
from heatlens.studio.session.shared import Commands, Shared

_ASSUMED_LENS = "The file has no lens: the ruler uses the current one."


@dataclass(frozen=True)
class Measurement:
    """The result: the depths of both points, and the distance between them, in m."""

    depths_m: tuple[float, float]
    distance_m: float


class Ruler(Commands):
    """The clicked points; the measurement follows the current frame."""

    def __init__(self, shared: Shared, view: PictureView) -> None:
        super().__init__(shared)
        self._view = view
        self.is_on = False
        self.points: tuple[Pixel, ...] = ()

    def why_not(self) -> str:
        """Return a sentence why nothing can be measured; "" if it can."""
        plate = self._source.plate
        if plate is None:
            return "Nothing is open."
        return "" if plate.has_distances else "The plate holds its blur and no distances."

    def toggle(self) -> None:
        """Switch the ruler on or off, and notify the user."""
        if self.switch_off():
            return
        self.is_on = True
        if not self._camera_mm:
            self._notify(_ASSUMED_LENS)

    def switch_off(self) -> bool:
        """Switch the ruler off; return True if it was on."""
        was_on, self.is_on, self.points = self.is_on, False, ()
        return was_on

    def press(self, pixel: Pixel) -> None:
        """Set the first or the second point; a third press starts again with a first one."""
        if self.is_inside(pixel):
            self.points = (self.points[0], pixel) if len(self.points) == 1 else (pixel,)

    def drag(self, pixel: Pixel) -> None:
        """Move the second point while the mouse button is held."""
        if self.points and pixel != self.points[0] and self.is_inside(pixel):
            self.points = (self.points[0], pixel)

    def measure(self, hovered: Pixel | None = None) -> Measurement | None:
        """Return the measurement; `hovered` is used if there is no second point.

        Return None without two points, or if one is at infinity.
        """
        ends = self.points if len(self.points) == 2 or hovered is None else (*self.points, hovered)
        plate = self._source.plate
        if len(ends) != 2 or plate is None or not all(self.is_inside(end) for end in ends):
            return None
        ends = tuple(self._source.frame_px(self._editing.lens, end) for end in ends)
        with report_errors(self._notify):
            plate_pixels = [self._source.feed.plate_px(self._editing.shot, end) for end in ends]
            first_m, second_m = (depth_at_m(plate, *end) for end in plate_pixels)
            camera = self._camera(plate)
            a, b = camera.point_m(ends[0], first_m), camera.point_m(ends[1], second_m)
            return Measurement((first_m, second_m), math.dist(a, b))
        return None

    def is_inside(self, pixel: Pixel) -> bool:
        """Return True if the pixel is in the picture and the picture has distances."""
        plate = self._source.plate
        if plate is None or not plate.has_distances:
            return False
        return plate.contains_pixel(
            *self._source.plate_px(self._editing.lens, self._editing.shot, pixel)
        )

    @property
    def _camera_mm(self) -> tuple[float, float] | None:
        """Focal length and sensor width of the camera of the plate in mm, where known."""
        plate = self._source.plate
        camera = None if plate is None else plate.camera
        if camera is None or camera.focal_length_mm is None or camera.sensor_width_mm is None:
            return None
        return camera.focal_length_mm, camera.sensor_width_mm

    def _camera(self, plate: Plate) -> Intrinsics:
        """Return the camera that made the picture; unknown values are those of the shot's lens."""
        lens, camera_mm = self._editing.lens, self._camera_mm
        shape = desqueezed_shape(self._view.state, self._source.picture_shape(self._editing.shot))
        return Intrinsics(*(camera_mm or (lens.focal_length_mm, lens.sensor_width_mm)), shape)
