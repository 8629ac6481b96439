"""What a command says: its result, and sentences beside it."""

import sys
from typing import TextIO

from heatlens.printable import printable

_is_quiet = False


def say_nothing(is_quiet: bool) -> None:
    """Set whether only results and errors are printed (`--quiet`)."""
    global _is_quiet
    _is_quiet = is_quiet


def shows_progress(stream: TextIO) -> bool:
    """Return whether somebody who wants to see progress looks at `stream`."""
    return stream.isatty() and not _is_quiet


def tell(text: str, keep: str = "") -> None:
    """Print a result on stdout, at once; what would steer a terminal is written out, but `keep`."""
    print(printable(text, keep), flush=True)


def say(*sentences: str) -> None:
    """Print each sentence on a line of its own on stderr, at once.

    What follows may take minutes.
    """
    for sentence in () if _is_quiet else sentences:
        print(f"heatlens: {printable(sentence)}", file=sys.stderr, flush=True)
