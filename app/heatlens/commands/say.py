"""What a command says: its result, and sentences beside it."""

import sys
from typing import TextIO

from heatlens.printable import printable

_is_quiet = False


def say_nothing(is_quiet: bool) -> None:
    """Whether the command was asked to give results and errors alone (`--quiet`)."""
    global _is_quiet
    _is_quiet = is_quiet


def shows_progress(stream: TextIO) -> bool:
    """Whether somebody looks at `stream` who wants to know how far it is."""
    return stream.isatty() and not _is_quiet


def tell(text: str, keep: str = "") -> None:
    """Print a result on stdout, at once; what would steer a terminal is written out, but `keep`."""
    print(printable(text, keep), flush=True)


def say(*sentences: str) -> None:
    """Each on a line of its own on stderr, at once: what follows may take minutes."""
    for sentence in () if _is_quiet else sentences:
        print(f"heatlens: {printable(sentence)}", file=sys.stderr, flush=True)
