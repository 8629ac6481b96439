"""Measure the marks of the open shot: their distances, and the focus with which they are sharp.

Picking the thing at a pixel and reading frames to follow one happen on a thread. A mark on a
surface follows it through the frames of the sequence.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from math import inf

from heatlens.base.background import Background
from heatlens.base.errors import InputError
from heatlens.frame_cache.cache import Damaged, FrameCache
from heatlens.model.curves.frames import FrameRange
from heatlens.model.focus.lean import lean_of
from heatlens.model.focus.live_focus import Distances
from heatlens.model.lens.lens import Lens
from heatlens.model.marks.mark import Mark
from heatlens.model.marks.marks import MatteMark, ObjectMark, PointMark, distance_at_m
from heatlens.model.marks.track_mark import TrackMark, TrackPlace
from heatlens.model.shot.plate_options import PlateOptions
from heatlens.plate.coc_line import sharp_at
from heatlens.plate.mattes.mattes import thing_at
from heatlens.plate.plate import Plate
from heatlens.plate.read import read_plate
from heatlens.plate.tracking.tracked_mark import tracked
from heatlens.session.loop.messages import Worker
from heatlens.session.opened.open_source import OpenSource
from heatlens.session.scenes.scene_commands import SceneCommands
from heatlens.session.shared import Commands, Shared
from heatlens.session.time.focus_track import ThingDistances, mark_m
from heatlens.session.time.timeline import Timeline


def on_thing(plate: Plate, point: PointMark) -> PointMark | MatteMark:
    """Return a mark on the thing under a point; the point itself where there is none."""
    thing = thing_at(plate, int(point.x_px), int(point.y_px))
    return point if thing is None else MatteMark(point.name, thing)


def smoothed(mark: Mark, distances_m: Distances, frames: FrameRange) -> Distances:
    """Return the distances with as many frames averaged as the mark asks for."""
    if not isinstance(mark, PointMark) or mark.smooth_frames == 1:
        return distances_m

    def depth_at(frame: int, x: float, y: float) -> float:
        return distances_m[frame] or inf

    return {frame: distance_at_m(mark, frame, depth_at, frames) for frame in frames}


def reading_options(source: OpenSource) -> PlateOptions:
    """Return the options with which the plates of the open source are read."""
    return PlateOptions() if source.opened is None else source.opened.settled


def plates_at(
    cache: FrameCache, options: PlateOptions, frames: FrameRange
) -> Iterator[tuple[int, Plate]]:
    """Return the plate of each frame, see `plate_at`."""
    return ((frame, plate_at(cache, options, frame)) for frame in frames)


def plate_at(cache: FrameCache, options: PlateOptions, frame: int) -> Plate:
    """Return the plate of a frame from memory, or read it. Raise HeatlensError if it is damaged."""
    stands_in = cache.sequence.shown_frame(frame)
    assert stands_in is not None  # a sequence has at least one frame to hold
    found = cache.get(stands_in)
    if isinstance(found, Damaged):
        raise InputError(found.sentence)
    return found or read_plate(cache.sequence.path_at(stands_in), options)


class SurfaceTracking(Commands, Worker):
    """Tracks one mark at a time; a newer one replaces it."""

    def __init__(self, shared: Shared, take: Callable[[Mark, TrackMark], None]) -> None:
        """Create it; `take` is given the mark as it was at the start, and the tracked one."""
        super().__init__(shared)
        self._take = take
        self._tracker: Background[tuple[Mark, TrackMark]] = Background(self._wake)
        self._reached = self._said = ""  # how far the thread is

    @property
    def is_busy(self) -> bool:
        """True while a surface is followed."""
        return self._tracker.is_busy

    def start(self, before: Mark, mark: TrackMark, cache: FrameCache, frames: FrameRange) -> None:
        """Follow a mark that will take the place of `before`."""
        read = partial(plate_at, cache, reading_options(self._source))
        self._tracker.start(lambda: (before, tracked(mark, frames, read, self._show)))

    def _show(self, words: str) -> None:
        """Note how far it is; called on the thread."""
        self._reached = words
        self._wake()

    def poll(self) -> None:
        """Say how far it is, and hand over the mark; call this once a frame."""
        if self._reached != self._said:
            self._said = self._reached
            self._say(self._said)
        found = self._tracker.poll()
        if found is not None:
            self._take(*found)


class MarkDistances(Commands):
    """Measures marks on what is open; `things` measures those found by a matte, on a thread."""

    def __init__(
        self, shared: Shared, timeline: Timeline, scenes: SceneCommands, things: ThingDistances
    ) -> None:
        super().__init__(shared)
        self._timeline, self._scenes, self._things = timeline, scenes, things

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
