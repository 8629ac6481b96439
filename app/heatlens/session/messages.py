"""What the program says to its user: one sentence at a time, shown for a while."""

import re
import time
from collections.abc import Callable

from heatlens.printable import printable

SHOWN_S = 12.0


class Problem(str):
    """A sentence about what went wrong or cannot be done; it is shown in another colour."""

    __slots__ = ()


class Messages:
    """The sentence that was said last, until it has been shown for `SHOWN_S` seconds."""

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self.text = ""
        self.is_problem = False
        self._clock = clock
        self._said_at = 0.0
        self._stays = False  # until something else is said, or it is cleared

    def say(self, sentence: str) -> None:
        """Show a sentence in the place of the one before."""
        self.text, self._said_at = window_words(sentence), self._clock()
        self.is_problem = isinstance(sentence, Problem)

    def clear(self) -> None:
        """Show nothing."""
        self.text = ""

    def fade(self, keeps_problem: bool = False) -> None:
        """Clear a sentence that has been shown long enough; call this once a frame.

        `keeps_problem`: one that says what went wrong stays, however long it has been shown.
        """
        self._stays = keeps_problem and self.is_problem
        if self.text and not self._stays and self._clock() - self._said_at > SHOWN_S:
            self.text = ""

    def seconds_until_needed(self) -> float | None:
        """Return how long the loop may sleep before `fade`; None: there is nothing to clear."""
        return SHOWN_S if self.text and not self._stays else None


def window_words(sentence: str) -> str:
    """Return a sentence with the options of the command line named as the panels name them."""
    said = printable(sentence)
    return re.sub(r"--([a-z]+(?:-[a-z]+)*)", lambda match: match[1].replace("-", " "), said)
