"""Show progress in one line of the terminal, which is rewritten and then cleared."""

import io
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import TextIO

from heatlens.commands.output.say import say, shows_progress
from heatlens.measure.bench.pace import Pace, Step

_WIPE = "\r\x1b[K"


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

    Sentences that are not in the plan, such as notes on skipped parts, stay on their own lines; ""
    clears the line of the progress.
    """
    pace = Pace(steps, clock)
    say(f"this takes about {time_text(pace.left_s)}; Ctrl-C ends it")
    with progress_line() as show:

        def tell(sentence: str) -> None:
            if pace.begin(sentence):
                where = f"{pace.number} of {len(pace.steps)}, about {time_text(pace.left_s)} left"
                show(f"{sentence} ({where})")
                return
            show("")
            say(*filter(None, [sentence]))

        yield tell
