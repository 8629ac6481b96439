"""The names of what the loupe shows, from the mattes of a plate, read on a thread."""

from collections.abc import Callable, Sequence

from heatlens.base.background import Background
from heatlens.plate.blurred_pick import Surface
from heatlens.plate.mattes.mattes import has_things, thing_at
from heatlens.plate.plate import Plate

_Names = tuple[str, ...]


class ThingsHere:
    """The name of each of the surfaces asked for last, "" until it is known."""

    def __init__(self, wake: Callable[[], None]) -> None:
        self._asked: tuple[Plate, tuple[Surface, ...]] | None = None
        self._names: _Names = ()
        self._reader: Background[_Names] = Background(wake)

    def names(self, plate: Plate, surfaces: Sequence[Surface]) -> _Names:
        """Return the names of surfaces, or begin to look for them."""
        asked, before = (plate, tuple(surfaces)), self._asked
        if before is None or before[0] is not plate or before[1] != asked[1]:
            self._asked, self._names = asked, ("",) * len(surfaces)
            self._reader.cancel()
            if has_things(plate):
                self._reader.start(lambda: tuple(_name(plate, it) for it in asked[1]))
        self._names = self._reader.poll() or self._names
        return self._names


def _name(plate: Plate, surface: Surface) -> str:
    return (thing_at(plate, surface.x, surface.y) or "").partition(":")[2]
