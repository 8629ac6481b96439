"""The distances of marks over the frames, in dioptres."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import groupby, pairwise
from weakref import WeakKeyDictionary

from heatlens.core.base.background import Background
from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.messages import Worker
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.marks.marks import DistanceMark, MatteMark, MattePart, ObjectMark
from heatlens.core.model.marks.track_mark import TrackMark
from heatlens.media.frame_cache.cache import FrameCache
from heatlens.media.frame_cache.frame_states import Run
from heatlens.media.plate.mark_distance import mark_on_plate_m
from heatlens.media.plate.mattes.mattes import thing_distance_m
from heatlens.media.plate.plate import Plate

MarkLine = tuple[tuple[int, float], ...]  # (frame, 1/m)


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
        visible_parts = [
            tuple((frame, dioptres) for frame, dioptres in visible_part if dioptres is not None)
            for _, visible_part in groupby(run, key=lambda sample: sample[1] is None)
        ]
        run_lines = [visible_part for visible_part in visible_parts if visible_part]
        lines += run_lines
        bridges += [(line[-1], next_line[0]) for line, next_line in pairwise(run_lines)]
    return MarkTrack(name, lines=tuple(lines), bridges=tuple(bridges))


_MatteKey = tuple[str, MattePart]


class MatteDistances(Worker):
    """The distances of mattes on plates in memory, each measured once, on a thread."""

    def __init__(self, wake: Callable[[], None]) -> None:
        self._reader: Background[tuple[Plate, _MatteKey, float | None]] = Background(wake)
        self._distances_m: WeakKeyDictionary[Plate, dict[_MatteKey, float | None]] = (
            WeakKeyDictionary()
        )
        self.measured_count = 0  # increases with each measurement, so that others notice it

    def distance_m(self, plate: Plate, mark: MatteMark) -> float | None:
        """Return the distance in m; None where it is hidden, and until it is measured."""
        distances_m, matte_key = self._distances_m.get(plate, {}), (mark.matte, mark.part)
        if matte_key not in distances_m and not self._reader.is_busy:
            self._reader.start(lambda: (plate, matte_key, _measure_matte_m(plate, matte_key)))
        return distances_m.get(matte_key)

    def is_measured(self, plate: Plate, mark: MatteMark) -> bool:
        """Return True if the matte of a mark has been measured on a plate."""
        return (mark.matte, mark.part) in self._distances_m.get(plate, {})

    def poll(self) -> None:
        """Store a measured distance; call this once a frame."""
        if (measurement := self._reader.poll()) is not None:
            plate, matte_key, distance_m = measurement
            self._distances_m.setdefault(plate, {})[matte_key] = distance_m
            self.measured_count += 1


def _measure_matte_m(plate: Plate, matte_key: _MatteKey) -> float | None:
    """Return the distance of a matte on a plate in m; None if it is hidden or unusable."""
    try:
        return thing_distance_m(plate, *matte_key)
    except HeatlensError:  # reported where the mark is used, as in `follow`
        return None


class MarkTracks:
    """The distance tracks of marks on points and mattes; each plate is measured once."""

    def __init__(self, matte_distances: MatteDistances) -> None:
        self._matte_distances = matte_distances
        self._measured: WeakKeyDictionary[Plate, dict[Mark, float]] = WeakKeyDictionary()
        self._tracks_key: object = None
        self._tracks: tuple[MarkTrack, ...] = ()

    def tracks(
        self, cache: FrameCache | None, runs: tuple[Run, ...], marks: tuple[Mark, ...]
    ) -> tuple[MarkTrack, ...]:
        """Return the track of every mark that moves over the frames in memory."""
        key = (id(cache), runs, marks, self._matte_distances.measured_count)
        if cache is not None and key != self._tracks_key:
            ready_runs = [run for run in runs if run.state == "ready"]
            moving_marks = [
                mark for mark in marks if not isinstance(mark, DistanceMark | ObjectMark)
            ]
            self._tracks = tuple(self._track(cache, ready_runs, mark) for mark in moving_marks)
            self._tracks_key = key
        return self._tracks

    def _track(self, cache: FrameCache, ready_runs: list[Run], mark: Mark) -> MarkTrack:
        """Return the track of a mark: as it was tracked, or measured on the plates in memory."""
        if isinstance(mark, TrackMark):
            samples = ((place.frame, place.distance_m) for place in mark.places)
            dioptres = [(frame, distance_m and 1.0 / distance_m) for frame, distance_m in samples]
            return mark_track(mark.name, [dioptres])
        runs = [
            [
                (number, self._dioptres(cache.get(number), mark))
                for number in range(run.first, run.last + 1)
            ]
            for run in ready_runs
        ]
        return mark_track(mark.name, runs)

    def _dioptres(self, plate: object, mark: Mark) -> float | None:
        """Return the distance of a mark on a plate in 1/m; None if it is hidden or unknown."""
        if not isinstance(plate, Plate):
            return None
        if isinstance(mark, MatteMark):
            distance_m = self._matte_distances.distance_m(plate, mark)
            return None if distance_m is None else 1.0 / distance_m
        measured = self._measured.setdefault(plate, {})
        if mark not in measured:
            distance_m = mark_m(plate, mark)
            if distance_m is None:
                return None
            measured[mark] = 1.0 / distance_m
        return measured[mark]


def mark_m(plate: Plate | None, mark: Mark) -> float | None:
    """Return the distance of a mark on this plate in m; None if it is unknown."""
    if isinstance(mark, DistanceMark):
        return mark.distance_m
    try:
        return None if plate is None else mark_on_plate_m(plate, mark)
    except HeatlensError:  # outside the picture
        return None
