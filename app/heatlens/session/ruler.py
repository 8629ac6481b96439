"""The ruler: the distance in the world between two points of the picture."""

from collections.abc import Callable
from dataclasses import dataclass

from heatlens.errors import HeatlensError
from heatlens.model.ruler import Intrinsics, distance_m
from heatlens.model.view_geometry import shown_shape
from heatlens.plate.focus_pick import depth_at_m
from heatlens.plate.plate import Plate
from heatlens.session.editing import Editing
from heatlens.session.messages import Problem
from heatlens.session.open_source import OpenSource
from heatlens.session.picture_view import PictureView

Pixel = tuple[int, int]

_ASSUMED = "The file tells no lens: the ruler goes by the one that is set."


@dataclass(frozen=True)
class Measured:
    """What the ruler tells: the depths of both points, and how far they are from each other."""

    depths_m: tuple[float, float]
    distance_m: float


class Ruler:
    """Holds the points that were clicked; what they measure follows the frame."""

    def __init__(
        self,
        source: OpenSource,
        editing: Editing,
        view: PictureView,
        say: Callable[[str], None],
    ) -> None:
        self._source = source
        self._editing = editing
        self._view = view
        self._say = say
        self.is_on = False
        self.points: tuple[Pixel, ...] = ()

    def why_not(self) -> str:
        """Return why nothing can be measured; "" where it can."""
        plate = self._source.plate
        if plate is None:
            return "Nothing is open."
        return "" if plate.has_distances else "The plate tells its blur and no distances."

    def toggle(self) -> None:
        """Take the ruler, or put it away."""
        if self.leave():
            return
        self.is_on = True
        if not self._told_mm:
            self._say(_ASSUMED)

    def leave(self) -> bool:
        """Put the ruler away; return whether it was out."""
        was_on, self.is_on, self.points = self.is_on, False, ()
        return was_on

    def press(self, pixel: Pixel) -> None:
        """Set the first point, or the second where there is a first; a third begins anew."""
        if self._is_inside(pixel):
            self.points = (self.points[0], pixel) if len(self.points) == 1 else (pixel,)

    def drag(self, pixel: Pixel) -> None:
        """Move the second point while the button is held."""
        if self.points and pixel != self.points[0] and self._is_inside(pixel):
            self.points = (self.points[0], pixel)

    def measured(self, to: Pixel | None = None) -> Measured | None:
        """Return the distance of the points, `to` in the place of a second that is missing.

        None where there are no two, or one is infinitely far away.
        """
        ends = self.points if len(self.points) == 2 or to is None else (*self.points, to)
        plate = self._source.plate
        if len(ends) != 2 or plate is None or not all(self._is_inside(end) for end in ends):
            return None
        ends = tuple(self._source.frame_px(self._editing.lens, end) for end in ends)
        try:
            near_m, far_m = (self._depth_m(plate, end) for end in ends)
        except HeatlensError as error:
            self._say(Problem(error))
            return None
        camera = self._camera(plate)
        a, b = camera.point_m(ends[0], near_m), camera.point_m(ends[1], far_m)
        return Measured((near_m, far_m), distance_m(a, b))

    def _depth_m(self, plate: Plate, pixel: Pixel) -> float:
        return depth_at_m(plate, *self._source.plate_px(self._editing.shot, pixel))

    def _is_inside(self, pixel: Pixel) -> bool:
        plate = self._source.plate
        if plate is None or not plate.has_distances:
            return False
        frame_px = self._source.frame_px(self._editing.lens, pixel)
        x, y = self._source.plate_px(self._editing.shot, frame_px)
        window = plate.display_window
        return plate.data_window.contains(x + window.x0, y + window.y0)

    @property
    def _told_mm(self) -> tuple[float, float] | None:
        """Focal length and sensor width of the camera that made the plate; a scene's tells both."""
        plate = self._source.plate
        camera = None if plate is None else plate.camera
        if camera is None or camera.focal_length_mm is None or camera.sensor_width_mm is None:
            return None
        return camera.focal_length_mm, camera.sensor_width_mm

    def _camera(self, plate: Plate) -> Intrinsics:
        """Return the camera that made the picture; the lens that is set where none is told."""
        lens, told_mm = self._editing.lens, self._told_mm
        shape = shown_shape(self._view.state, self._source.picture_shape(self._editing.shot))
        return Intrinsics(*(told_mm or (lens.focal_length_mm, lens.sensor_width_mm)), shape)
