"""Define the generator type of all work that is done in steps, and how far such work has come."""

from collections.abc import Generator
from typing import NamedTuple, TypeVar

Result = TypeVar("Result")

# Yields the name of each pass once its work is issued to the GPU, and returns the result. A window
# can handle input between two steps.
Steps = Generator[str, None, Result]


class Turn(NamedTuple):
    """The position of a picture among several that take equally long, for reporting progress.

    before    how many of them are done
    pictures  how many there are
    """

    before: int
    pictures: int

    @property
    def halves(self) -> "tuple[Turn, Turn]":
        """The turns of two pictures that together take the time of this one."""
        before, pictures = 2 * self.before, 2 * self.pictures
        return Turn(before, pictures), Turn(before + 1, pictures)


ONLY = Turn(0, 1)  # the turn of a picture that is rendered alone
