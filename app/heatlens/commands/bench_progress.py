"""How far `heatlens bench` is: a line that is rewritten on a terminal, else a line for a part."""

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
    """Called with each sentence of the bench; a context that leaves a clean line behind.

    Sentences that are no part of the plan, such as what was left out, stay as lines of their own.
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
