"""Looks: lenses kept under a name, to compare and return to."""

from collections.abc import Iterable
from dataclasses import dataclass, field

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens

_STILL_MOST = 100_000  # letters; a still has some 10,000


@dataclass(frozen=True, slots=True)
class Look:
    """The lens as it was at a frame, under a name.

    still  a small JPEG of the picture at that time, in base64; None if there was none

    Raises InputError for a name that cannot be shown, and a still that is too large.
    """

    name: str
    lens: Lens
    frame: int = 1
    still: str | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        if not self.name or not self.name.isprintable() or self.name != self.name.strip():
            raise InputError(
                f"A look needs a name of letters without spaces at its ends, not {self.name!r}."
            )
        if self.still is not None and not (self.still.isascii() and len(self.still) <= _STILL_MOST):
            raise InputError(
                f"The small picture of look {self.name} is damaged or too large: keep the look "
                "again, with Shift+L in the window."
            )


def check_looks(looks: Iterable[Look]) -> None:
    """Raise InputError if two looks have one name."""
    names = [look.name for look in looks]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"Two looks are called {name}: rename one.")
