"""The messages to the user, one at a time, and the base of what is polled once a frame."""

import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Self

from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.log import LOG
from heatlens.core.base.outside_text import printable


class Worker:
    """The base of every worker, which has nothing to do.

    A session holds its workers in one tuple, so that none is polled but forgotten when the loop
    sleeps.
    """

    def poll(self) -> None:
        """Use the results that have arrived, and continue. Raise HeatlensError if that fails."""

    def seconds_until_needed(self) -> float | None:
        """Return how many seconds the loop may sleep; None to sleep until an event."""
        return None

    def close(self) -> None:
        """Finish writing, and end all threads."""


SHOWN_S = 12.0


class Problem(str):
    """A message about an error or something impossible; it is shown in another color."""

    __slots__ = ("cause",)

    def __init__(self, cause: object) -> None:
        """Show the words of `cause`, an error or a sentence."""
        self.cause = cause


class Lasting(Problem):
    """A problem in the background: its message stays until it is replaced or cleared."""

    __slots__ = ()


class Passing(str):
    """A message that is shown only while it is true."""

    __slots__ = ("is_true",)

    def __new__(cls, sentence: str, _is_true: Callable[[], bool]) -> Self:
        """Return the sentence."""
        return super().__new__(cls, sentence)

    def __init__(self, _sentence: str, is_true: Callable[[], bool]) -> None:
        """Show it until `is_true` returns False."""
        self.is_true = is_true


class Explained(str):
    """A sentence with the details behind it, which `--verbose` prints and the log keeps."""

    __slots__ = ("why",)

    def __new__(cls, sentence: str, _why: str) -> Self:
        """Return the sentence."""
        return super().__new__(cls, sentence)

    def __init__(self, _sentence: str, why: str) -> None:
        """Keep the details, in sentences."""
        self.why = why

    def __reduce__(self) -> tuple[type[Self], tuple[str, str]]:
        """Return what a copy in another process is made of."""
        return type(self), (str(self), self.why)


def passing_message(sentence: str, is_true: Callable[[], bool]) -> Passing:
    """Return a message that disappears as soon as `is_true` returns False."""
    return Passing(sentence, is_true)


@contextmanager
def report_errors(notify: Callable[[str], None]) -> Iterator[None]:
    """Show a HeatlensError that the block raises as a message."""
    try:
        yield
    except HeatlensError as error:
        notify(Problem(error))


class Messages(Worker):
    """The latest message, until it has been shown for `SHOWN_S` seconds."""

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self.text = ""
        self.cause: object = None  # of a Problem; None for other messages
        self._clock = clock
        self._shown_since = 0.0
        self._is_lasting = False
        self._is_still_true: Callable[[], bool] = _always
        self._is_kept_on_screen = False  # the message stays until it is replaced or cleared

    def notify(self, sentence: str) -> None:
        """Show a sentence instead of the previous one; its type tells how, and for how long."""
        LOG.info("%s", printable(sentence))
        self.text, self._shown_since = window_words(sentence), self._clock()
        self.cause = sentence.cause if isinstance(sentence, Problem) else None
        self._is_lasting = isinstance(sentence, Lasting)
        self._is_still_true = sentence.is_true if isinstance(sentence, Passing) else _always

    @property
    def is_problem(self) -> bool:
        """True if the message is about an error or something impossible."""
        return self.cause is not None

    def clear(self) -> None:
        """Show no message from now on."""
        self.text = ""

    def fade(self, keeps_problem: bool = False) -> None:
        """Clear a message that was shown long enough or is true no longer; call this once a frame.

        With `keeps_problem`, a Problem stays until it is replaced or cleared.
        """
        self._is_kept_on_screen = self._is_lasting or (keeps_problem and self.is_problem)
        is_over = not self._is_kept_on_screen and self._clock() - self._shown_since > SHOWN_S
        if self.text and (is_over or not self._is_still_true()):
            self.text = ""

    def seconds_until_needed(self) -> float | None:
        """Return the seconds until `fade` has something to clear; None if it has nothing."""
        return SHOWN_S if self.text and not self._is_kept_on_screen else None


def _always() -> bool:
    return True


def window_words(sentence: str) -> str:
    """Return a sentence with names of command-line options replaced by those in the panels."""
    words = printable(sentence)
    return re.sub(r"--([a-z]+(?:-[a-z]+)*)", lambda match: match[1].replace("-", " "), words)
