"""The focus and its range of sharpness per frame, and the distances of marks, in dioptres."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import groupby, pairwise
from weakref import WeakKeyDictionary

from heatlens.core.base.background import Background
from heatlens.core.base.errors import HeatlensError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.coc import far_limit_m, near_limit_m
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.marks.marks import DistanceMark, MatteMark, MattePart, ObjectMark
from heatlens.core.model.marks.track_mark import TrackMark
from heatlens.core.model.shot.pull import frames_too_close
from heatlens.core.model.shot.shot import Shot
from heatlens.media.frame_cache.cache import FrameCache
from heatlens.media.plate.mark_distance import mark_on_plate_m
from heatlens.media.plate.mattes.mattes import thing_m
from heatlens.media.plate.plate import Plate
from heatlens.studio.session.messages import Worker
from heatlens.studio.session.time.timeline import Run

MarkLine = tuple[tuple[int, float], ...]  # (frame, 1/m)
_WARNED_MOST = 2000  # frames that are checked for a focus that is too close


@dataclass(frozen=True, slots=True)
class Sample:
    """One time, with the focus and the limits of the sharp range in 1/m."""

    frame: float
    focus: float
    near: float
    far: float


class FocusTrack:
    """The samples over the visible frames, recomputed when these or the shot change."""

    def __init__(self) -> None:
        self._made_of: object = None
        self._samples: tuple[Sample, ...] = ()
        self._warned_of: object = None
        self._too_close: tuple[int, ...] = ()

    def samples(self, shot: Shot, first: float, last: float, count: int) -> tuple[Sample, ...]:
        """Return `count` evenly spaced samples from first to last, and one at every key between."""
        made_of = (shot.lens, shot.curves, first, last, count)
        if made_of != self._made_of:
            times = {first + (last - first) * i / (count - 1) for i in range(count)}
            times |= {frame for frame in shot.key_frames if first <= frame <= last}
            self._samples = tuple(_sample(shot, time) for time in sorted(times))
            self._made_of = made_of
        return self._samples

    def too_close(self, shot: Shot, frames: FrameRange) -> tuple[int, ...]:
        """Return the visible frames at which the lens cannot focus as near as it should."""
        made_of = (shot.lens, shot.curves, frames)
        if made_of != self._warned_of:
            self._too_close, self._warned_of = _too_close(shot, frames), made_of
        return self._too_close


def _too_close(shot: Shot, frames: FrameRange) -> tuple[int, ...]:
    if frames.count > _WARNED_MOST:
        return ()
    try:
        return frames_too_close(Shot(shot.lens, curves=shot.curves, frames=frames))
    except HeatlensError:  # no valid lens at some frame; reported where that frame is shown
        return ()


def _sample(shot: Shot, time: float) -> Sample:
    try:
        lens = shot.lens_at(time)
    except HeatlensError:  # between two keys of a long lens and a near focus
        return Sample(time, 0.0, 0.0, 0.0)
    return Sample(
        time, 1.0 / lens.focus_distance_m, 1.0 / near_limit_m(lens), 1.0 / far_limit_m(lens)
    )


@dataclass(frozen=True)
class MarkTrack:
    """The distance of a mark in 1/m at the frames in memory, as lines without gaps.

    `bridges` go from the end of a line to the next one where the mark is hidden between them.
    """

    name: str
    lines: tuple[MarkLine, ...]
    bridges: tuple[MarkLine, ...] = ()


def mark_track(name: str, runs: Iterable[Iterable[tuple[int, float | None]]]) -> MarkTrack:
    """Return the track of a mark from runs of frames; None where it is hidden."""
    lines: list[MarkLine] = []
    bridges: list[MarkLine] = []
    for run in runs:
        parts = [
            tuple((frame, place) for frame, place in part if place is not None)
            for _, part in groupby(run, key=lambda it: it[1] is None)
        ]
        lengths = [part for part in parts if part]
        lines += lengths
        bridges += [(before[-1], after[0]) for before, after in pairwise(lengths)]
    return MarkTrack(name, tuple(lines), tuple(bridges))


_Thing = tuple[str, MattePart]


class ThingDistances(Worker):
    """The distances of things on plates in memory, each measured once."""

    def __init__(self, wake: Callable[[], None]) -> None:
        self._reader: Background[tuple[Plate, _Thing, float | None]] = Background(wake)
        self._known: WeakKeyDictionary[Plate, dict[_Thing, float | None]] = WeakKeyDictionary()
        self.measured_count = 0  # increases with each measurement, so that others know when to ask

    def distance_m(self, plate: Plate, mark: MatteMark) -> float | None:
        """Return the distance in m; None where it is hidden, and until it is measured."""
        known, thing = self._known.get(plate, {}), (mark.matte, mark.part)
        if thing not in known and not self._reader.is_busy:
            self._reader.start(lambda: (plate, thing, _measured(plate, thing)))
        return known.get(thing)

    def is_measured(self, plate: Plate, mark: MatteMark) -> bool:
        """Return True if the distance of a thing on a plate is known, or that it is hidden."""
        return (mark.matte, mark.part) in self._known.get(plate, {})

    def poll(self) -> None:
        """Take over a measured distance; call this once a frame."""
        if (picked := self._reader.poll()) is not None:
            plate, thing, distance_m = picked
            self._known.setdefault(plate, {})[thing] = distance_m
            self.measured_count += 1


def _measured(plate: Plate, thing: _Thing) -> float | None:
    try:
        return thing_m(plate, *thing)
    except HeatlensError:  # reported where the mark is used, as in `follow`
        return None


class MarkTracks:
    """The distance tracks of marks on points and things; each plate is measured once."""

    def __init__(self, things: ThingDistances) -> None:
        self._things = things
        self._measured: WeakKeyDictionary[Plate, dict[Mark, float]] = WeakKeyDictionary()
        self._made_of: object = None
        self._tracks: tuple[MarkTrack, ...] = ()

    def tracks(
        self, cache: FrameCache | None, runs: tuple[Run, ...], marks: tuple[Mark, ...]
    ) -> tuple[MarkTrack, ...]:
        """Return the track of every mark that moves over the frames in memory."""
        made_of = (id(cache), runs, marks, self._things.measured_count)
        if cache is not None and made_of != self._made_of:
            ready = [run for run in runs if run.state == "ready"]
            moving = [mark for mark in marks if not isinstance(mark, DistanceMark | ObjectMark)]
            self._tracks = tuple(self._track(cache, ready, mark) for mark in moving)
            self._made_of = made_of
        return self._tracks

    def _track(self, cache: FrameCache, ready: list[Run], mark: Mark) -> MarkTrack:
        if isinstance(mark, TrackMark):
            far_m = ((it.frame, it.distance_m) for it in mark.places)
            return mark_track(mark.name, [[(frame, it and 1.0 / it) for frame, it in far_m]])
        runs = [
            [(f, self._dioptres(cache.get(f), mark)) for f in range(run.first, run.last + 1)]
            for run in ready
        ]
        return mark_track(mark.name, runs)

    def _dioptres(self, plate: object, mark: Mark) -> float | None:
        if not isinstance(plate, Plate):
            return None
        if isinstance(mark, MatteMark):
            distance_m = self._things.distance_m(plate, mark)
            return None if distance_m is None else 1.0 / distance_m
        known = self._measured.setdefault(plate, {})
        if mark not in known:
            distance_m = mark_m(plate, mark)
            if distance_m is None:
                return None
            known[mark] = 1.0 / distance_m
        return known[mark]


def mark_m(plate: Plate | None, mark: Mark) -> float | None:
    """Return the distance of a mark on this plate in m; None if it is unknown."""
    if isinstance(mark, DistanceMark):
        return mark.distance_m
    try:
        return None if plate is None else mark_on_plate_m(plate, mark)
    except HeatlensError:  # outside the picture
        return None
