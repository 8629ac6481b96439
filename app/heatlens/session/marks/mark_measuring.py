"""Measure marks on plates, on a thread: pick the thing at a pixel, read frames to follow one."""

from collections.abc import Iterator
from math import inf

from heatlens.base.errors import InputError
from heatlens.frame_cache.cache import Damaged, FrameCache
from heatlens.model.curves.frames import FrameRange
from heatlens.model.focus.live_focus import Distances
from heatlens.model.marks.mark import Mark
from heatlens.model.marks.marks import MatteMark, PointMark, distance_at_m
from heatlens.model.shot.plate_options import PlateOptions
from heatlens.plate.mattes.mattes import thing_at
from heatlens.plate.plate import Plate
from heatlens.plate.read import read_plate
from heatlens.session.opened.open_source import OpenSource


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
