"""Measure marks on plates, on a thread: pick the thing at a pixel, read frames to follow one.

A mark on a surface follows it through the frames of the sequence.
"""

from collections.abc import Callable, Iterator
from functools import partial
from math import inf

from heatlens.base.background import Background
from heatlens.base.errors import InputError
from heatlens.frame_cache.cache import Damaged, FrameCache
from heatlens.model.curves.frames import FrameRange
from heatlens.model.focus.live_focus import Distances
from heatlens.model.marks.mark import Mark
from heatlens.model.marks.marks import MatteMark, PointMark, distance_at_m
from heatlens.model.marks.track_mark import TrackMark
from heatlens.model.shot.plate_options import PlateOptions
from heatlens.plate.mattes.mattes import thing_at
from heatlens.plate.plate import Plate
from heatlens.plate.read import read_plate
from heatlens.plate.tracking.tracked_mark import tracked
from heatlens.session.loop.worker import Worker
from heatlens.session.opened.open_source import OpenSource
from heatlens.session.shared import Commands, Shared


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
