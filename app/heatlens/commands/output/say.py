"""Print the result of a command to stdout, and messages to stderr."""

import sys
from typing import TextIO

from heatlens.base.outside_text import printable

_is_quiet = False


def say_nothing(is_quiet: bool) -> None:
    """Set whether only results and errors are printed (`--quiet`)."""
    global _is_quiet
    _is_quiet = is_quiet


def shows_progress(stream: TextIO) -> bool:
    """Return whether progress should be shown on `stream`: a terminal, without `--quiet`."""
    return stream.isatty() and not _is_quiet


def tell(text: str, keep: str = "") -> None:
    """Print a result on stdout and flush; control characters except `keep` are escaped."""
    print(printable(text, keep), flush=True)


def say(*sentences: str) -> None:
    """Print each sentence on its own line on stderr, and flush, unless `--quiet` is set."""
    for sentence in () if _is_quiet else sentences:
        print(f"heatlens: {printable(sentence)}", file=sys.stderr, flush=True)
