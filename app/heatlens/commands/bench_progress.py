"""Show the progress of `heatlens bench`: a rewritten line, or a line each without a terminal."""

import os
import sys
import time
from collections.abc import Callable
from types import TracebackType
from typing import TextIO

from heatlens.commands.export_progress import time_text
from heatlens.commands.say import say
from heatlens.measure.bench.schedule import Pace, Step

_WIPE = "\r\x1b[K"


class BenchProgress:
    """Is called with each sentence of the bench; as a context it clears its line at the end.

    Sentences that are not in the plan, such as notes on skipped parts, stay on their own lines.
    """

    def __init__(
        self, steps: tuple[Step, ...], clock: Callable[[], float] = time.perf_counter
    ) -> None:
        self._pace = Pace(steps, clock)
        self._terminal: TextIO | None = None

    def __enter__(self) -> "BenchProgress":
        if sys.stderr.isatty():
            self._terminal = open(os.dup(sys.stderr.fileno()), "w")  # closed below
        say(f"this takes about {time_text(self._pace.left_s)}; Ctrl-C ends it")
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if self._terminal is not None:
            self._terminal.write(_WIPE)
            self._terminal.close()
            self._terminal = None

    def __call__(self, sentence: str) -> None:
        """Begin a part, or print a message."""
        is_step = self._pace.begin(sentence)
        words = f"{sentence}{self._where()}" if is_step else sentence
        if self._terminal is None:
            say(words)
            return
        self._terminal.write(_WIPE)
        self._terminal.flush()
        if is_step:
            self._terminal.write(f"heatlens: {words}")
            self._terminal.flush()
        else:
            say(words)

    def _where(self) -> str:
        """Return "Part 3 of 20, about 40 s left"."""
        number, count = self._pace.number, len(self._pace.steps)
        return f" ({number} of {count}, about {time_text(self._pace.left_s)} left)"
