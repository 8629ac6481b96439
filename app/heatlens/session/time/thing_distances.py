"""Measure the things of plates by their mattes, on a thread: their files are read again."""

from collections.abc import Callable
from weakref import WeakKeyDictionary

from heatlens.base.background import Background
from heatlens.base.errors import HeatlensError
from heatlens.model.marks import MatteMark, MattePart
from heatlens.plate.mattes.matte_distance import thing_m
from heatlens.plate.plate import Plate
from heatlens.session.loop.worker import Worker

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

    def poll(self) -> None:
        """Take over a measured distance; call this once a frame."""
        found = self._reader.poll()
        if found is not None:
            plate, thing, distance_m = found
            self._known.setdefault(plate, {})[thing] = distance_m
            self.measured_count += 1


def _measured(plate: Plate, thing: _Thing) -> float | None:
    try:
        return thing_m(plate, *thing)
    except HeatlensError:  # reported where the mark is used, as in `follow`
        return None
