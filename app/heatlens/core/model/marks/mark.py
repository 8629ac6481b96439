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
    """A named thing or point to focus on. All that differs between the kinds is declared here.

    help      how it is typed, for the help of --mark
    prefix_pattern  a regular expression of the beginning of its text, before the text for `parse`
    entry     the entry in a shot file that no other kind has
    on_plate  function of (plate, mark) that measures the distance; None if a plate cannot
    """

    name: str

    help: ClassVar[str]
    prefix_pattern: ClassVar[str]
    entry: ClassVar[str]
    on_plate: ClassVar[OnUse | None] = None

    def __post_init__(self) -> None:
        if not self.name or not self.name.isprintable() or self.name != self.name.strip():
            raise InputError(
                f"A mark cannot be called {self.name!r}: a name has letters, and no spaces at its "
                "ends."
            )

    @classmethod
    @abstractmethod
    def parse(cls, name: str, text: str) -> Self:
        """Return the mark called `name` that `text` describes. Raises InputError."""

    @abstractmethod
    def location_words(self, distance: Callable[[float], str]) -> str:
        """Return words for where the mark is; `distance` formats meters in the user's unit."""

    @property
    @abstractmethod
    def meaning(self) -> str:
        """Words for what its distance is measured to."""

    def distance_at_m(self, frame: int) -> float | None:
        """Return its distance at a frame where no picture is needed for that; else None."""
        return None


def free_letter(used_names: Iterable[str]) -> str:
    """Return the first of A to Z, A1 to Z1, A2, … that is not a name of a mark, or of a look."""
    names = (f"{letter}{number or ''}" for number in count() for letter in ascii_uppercase)
    used = set(used_names)
    return next(name for name in names if name not in used)


def check_pixel(name: str, x_px: float, y_px: float) -> None:
    """Raise InputError for a pixel that no picture has."""
    for axis, value in (("x", x_px), ("y", y_px)):
        if not abs(value) < 1e6:
            raise InputError(
                f"Mark {name}: {axis} must be a number of pixels of the picture, got {value:g}."
            )


# A distance can be known, hidden or not known yet, and callers that need it wait for the frame.
# Without the third case, the focus bar, the list and the page showed the distance of the previous
# frame while a frame was being read, and a pull whose arrival was not in memory used the distance
# of the frame where it starts.
@dataclass(frozen=True)
class MarkDistance:
    """The distance of a mark at a frame, as far as it is known.

    distance_m   None where it is hidden, and where it is not known
    is_known     False while the frame is not in memory, or a thing is still being measured
    problem      a sentence why it cannot be known, or ""
    """

    distance_m: float | None = None
    is_known: bool = True
    problem: str = ""
