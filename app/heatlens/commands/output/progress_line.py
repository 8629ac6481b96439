"""Show progress in one line of the terminal, which is rewritten and then cleared."""

import io
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import TextIO

from heatlens.commands.output.say import shows_progress

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
