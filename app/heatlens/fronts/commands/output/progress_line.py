"""Show progress in one line of the terminal, which is rewritten and then cleared."""

import io
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import TextIO

from heatlens.core.base.pace import Pace, Step
from heatlens.fronts.commands.output.say import say, shows_progress

_WIPE = "\r\x1b[K"
_LONGER, _LONGER_S = 1.5, 5.0  # so many times and seconds longer than was said is said again


@contextmanager
def progress_line(stream: TextIO | None = None) -> Iterator[Callable[[str], None]]:
    """Yield a function that replaces the text of the line; "" clears it.

    Nothing is shown if `stream` (default stderr) is not a terminal, or with `--quiet`.
    """
    out = stream or sys.stderr
    if not shows_progress(out):
        yield lambda _: None
        return
    with _of_its_own(out) as line:

        def show(text: str) -> None:
            line.write(f"{_WIPE}heatlens: {text}" if text else _WIPE)
            line.flush()

        try:
            yield show
        finally:
            show("")


def _of_its_own(stream: TextIO) -> AbstractContextManager[TextIO]:
    """Return `stream` with its own descriptor, if it has one.

    Python's stderr is replaced at times while other threads read files, to hide messages of the EXR
    library.
    """
    try:
        return open(os.dup(stream.fileno()), "w", encoding=stream.encoding, errors=stream.errors)
    except io.UnsupportedOperation:
        return nullcontext(stream)


def time_text(seconds: float) -> str:
    """Return a duration as text, with the precision of an estimate."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 100 else f"{minutes // 60} h {minutes % 60} min"


@contextmanager
def paced_progress(
    steps: Sequence[Step], clock: Callable[[], float] = time.perf_counter
) -> Iterator[Callable[[str], None]]:
    """Print the expected time, and yield a function to call with the sentence of each step.

    The time is printed again where the steps so far show that it will be much longer.
    Sentences that are not in the plan, such as notes on skipped parts, stay on their own lines; ""
    clears the line of the progress.
    """
    pace = Pace(steps, clock)
    said_s = pace.left_s
    say(f"this takes about {time_text(said_s)}; Ctrl-C ends it")
    with progress_line() as show:

        def say_longer() -> None:
            nonlocal said_s
            if pace.whole_s > _LONGER * said_s + _LONGER_S:
                said_s = pace.whole_s
                show("")
                say(f"this takes longer here, about {time_text(said_s)} in all")

        def tell(sentence: str) -> None:
            if pace.begin(sentence):
                say_longer()
                where = f"{pace.number} of {len(pace.steps)}, about {time_text(pace.left_s)} left"
                show(f"{sentence} ({where})")
                return
            show("")
            if sentence:
                say(sentence)

        yield tell
