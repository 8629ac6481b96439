"""A focus mark: what every kind of mark declares."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import count
from string import ascii_uppercase
from typing import ClassVar, Self

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import OnUse


@dataclass(frozen=True, slots=True)
class Mark(ABC):
    """A named place to focus on. All that differs between the kinds of marks is declared here.

    help      what it is on and how it is typed, for the help of --mark
    begins    a regular expression of how its place is typed, up to what `typed` is given
    entry     the entry in a shot file that no other kind has
    on_plate  measures its distance on a plate (plate, mark); None where a plate does not tell it
    """

    name: str

    help: ClassVar[str]
    begins: ClassVar[str]
    entry: ClassVar[str]
    on_plate: ClassVar[OnUse | None] = None

    def __post_init__(self) -> None:
        if not self.name or not self.name.isprintable() or self.name != self.name.strip():
            raise InputError(f"A mark cannot be called {self.name!r}.")

    @classmethod
    @abstractmethod
    def typed(cls, name: str, place: str) -> Self:
        """Return the mark that somebody typed. Raises InputError."""

    @abstractmethod
    def where(self, distance: Callable[[float], str]) -> str:
        """Say where it is, for a list; `distance` writes metres in the user's unit."""

    @property
    @abstractmethod
    def meaning(self) -> str:
        """Say what its distance is measured to."""

    def distance_at_m(self, frame: int) -> float | None:
        """Return its distance at a frame where no picture is needed for that; else None."""
        return None


def free_letter(taken: Iterable[str]) -> str:
    """Return the first of A to Z, A1 to Z1, A2, … that is not a name of a mark, or of a look."""
    names = (f"{letter}{turn or ''}" for turn in count() for letter in ascii_uppercase)
    gone = set(taken)
    return next(name for name in names if name not in gone)


def check_pixel(name: str, x_px: float, y_px: float) -> None:
    """Raise InputError for a pixel that no picture has."""
    for axis, at in (("x", x_px), ("y", y_px)):
        if not abs(at) < 1e6:
            raise InputError(f"Mark {name}: {axis} cannot be {at:g} px.")
