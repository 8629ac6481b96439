"""Print the result of a command to stdout, and messages to stderr."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

from heatlens.core.base.outside_text import printable

_is_quiet = False
_gathered: dict[str, int] | None = None  # how often each sentence was said; None to print at once


def say_nothing(is_quiet: bool) -> None:
    """Set whether only results and errors are printed (`--quiet`)."""
    global _is_quiet
    _is_quiet = is_quiet


def shows_progress(stream: TextIO) -> bool:
    """Return whether progress should be shown on `stream`: a terminal, without `--quiet`."""
    # In a log, every step would be a line: a pull sheet wrote "picture 1 of 24" 24 times.
    return stream.isatty() and not _is_quiet


def tell(text: str, keep: str = "") -> None:
    """Print a result on stdout and flush; control characters except `keep` are escaped."""
    print(printable(text, keep), flush=True)


def say(*sentences: str) -> None:
    """Print each sentence on its own line on stderr, and flush, unless `--quiet` is set."""
    for sentence in () if _is_quiet else sentences:
        if _gathered is None:
            print(f"heatlens: {printable(sentence)}", file=sys.stderr, flush=True)
        else:
            _gathered[sentence] = _gathered.get(sentence, 0) + 1


@contextmanager
def said_once(shots: int) -> Iterator[None]:
    """Say each sentence of the block once, at its end, with the number of `shots` that it is about.

    What is said of each shot of a reel would fill the screen otherwise.
    """
    global _gathered
    _gathered = {}
    try:
        yield
    finally:
        said, _gathered = _gathered, None
        for sentence, times in said.items():
            of = f"all {shots} shots" if times >= shots else f"{times} of {shots} shots"
            say(sentence if times == 1 else f"{of}: {sentence}")
