"""How far the marks of the open shot are, and the focus with which they are sharp."""

from dataclasses import replace

from heatlens.base.errors import InputError
from heatlens.model.focus.lean import lean_of
from heatlens.model.lens.lens import Lens
from heatlens.model.marks.mark import Mark
from heatlens.model.marks.marks import MatteMark, ObjectMark, PointMark
from heatlens.model.marks.track_mark import TrackMark, TrackPlace
from heatlens.plate.coc_line import sharp_at
from heatlens.plate.plate import Plate
from heatlens.session.scenes.scene_commands import SceneCommands
from heatlens.session.shared import Commands, Shared
from heatlens.session.time.focus_track import ThingDistances, mark_m
from heatlens.session.time.timeline import Timeline


class MarkDistances(Commands):
    """Measures marks on what is open; `things` measures those found by a matte, on a thread."""

    def __init__(
        self, shared: Shared, timeline: Timeline, scenes: SceneCommands, things: ThingDistances
    ) -> None:
        super().__init__(shared)
        self._timeline, self._scenes, self._things = timeline, scenes, things

    def named(self, name: str | None) -> Mark | None:
        """Return the mark with this name."""
        return next((mark for mark in self._editing.shot.marks if mark.name == name), None)

    def of_m(self, mark: Mark, frame: int | None = None) -> float | None:
        """Return the distance of a mark in m, on the loaded plate or at another frame.

        Another frame must be of a scene or in memory; otherwise the loaded plate is used. Return
        None if the distance is unknown.
        """
        if isinstance(mark, ObjectMark):
            return self._scenes.object_m(mark.object_name, frame)
        known_m = mark.distance_at_m(self._editing.frame if frame is None else frame)
        if known_m is not None:
            return known_m
        cache, plate = self._timeline.cache, self._source.plate
        if isinstance(mark, PointMark) and self._source.has_camera:
            return self._in_scene_m(mark, frame)
        if frame is not None and cache is not None:
            found = cache.get(frame)
            plate = found if isinstance(found, Plate) else plate
        if isinstance(mark, MatteMark):
            return None if plate is None else self._things.distance_m(plate, mark)
        return mark_m(plate, mark)

    def _in_scene_m(self, mark: PointMark, frame: int | None) -> float | None:
        pixel = int(mark.x_px), int(mark.y_px)
        if frame is None or frame == self._editing.frame:
            x, y = self._source.feed.plate_px(self._editing.shot, pixel)
            return mark_m(self._source.plate, replace(mark, x_px=x, y_px=y))
        return self._scenes.point_m(*pixel, frame)

    def focus_m(self, mark: Mark, frame: int | None = None) -> float | None:
        """Return the focus distance with which a mark is sharp; None if it is unknown.

        It is not the distance of the mark where the plane of focus leans at the mark's point.
        """
        distance_m = self.of_m(mark, frame)
        lens = self._editing.lens if frame is None else self._editing.shot.lens_at(frame)
        at = self._editing.frame if frame is None else frame
        return None if distance_m is None else self.sharp_m(mark, lens, at, distance_m)

    def sharp_m(self, mark: Mark, lens: Lens, frame: int, distance_m: float) -> float:
        """Return the focus distance of `lens` with which a mark at this distance is sharp."""
        place = mark.place_at(frame) if isinstance(mark, TrackMark) else mark
        is_leaning = lens.tilt_deg or lens.split_dioptres
        if not (is_leaning and isinstance(place, PointMark | TrackPlace)):
            return distance_m
        shape = self._source.picture_shape(self._editing.shot)
        lean = lean_of(lens, (shape.width_px, shape.height_px), shape.pixel_aspect)
        return sharp_at(lens, lean, (place.x_px, place.y_px), distance_m).focus_distance_m

    def asked_focus_m(self, mark: Mark, frame: int | None) -> float:
        """Return `focus_m`; raise InputError if it is unknown."""
        distance_m = self.focus_m(mark, frame)
        if distance_m is None:
            raise InputError(
                f"Mark {mark.name} has no distance here: it is hidden or outside the picture."
            )
        return distance_m
