"""Print the result of a command to stdout, and messages to stderr."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

from heatlens.core.base.log import LOG
from heatlens.core.base.messages import Explained
from heatlens.core.base.outside_text import printable

_is_quiet = False
_message_counts: dict[str, int] | None = (
    None  # count of each gathered message; None to print at once
)


def set_quiet(is_quiet: bool) -> None:
    """Set whether only results and errors are printed (`--quiet`)."""
    global _is_quiet
    _is_quiet = is_quiet


def shows_progress(stream: TextIO) -> bool:
    """Return whether progress should be shown on `stream`: a terminal, without `--quiet`."""
    # In a log, every step would become a line: a pull sheet would write "picture 1 of 24" 24 times.
    return stream.isatty() and not _is_quiet


def print_result(text: str, keep: str = "") -> None:
    """Print a result on stdout and flush; control characters except `keep` are escaped."""
    print(printable(text, keep), flush=True)


def print_messages(*sentences: str) -> None:
    """Print each sentence on its own line on stderr, and flush, unless `--quiet` is set.

    The details of an explained one go to the log.
    """
    for sentence in () if _is_quiet else sentences:
        if _message_counts is None:
            LOG.info("%s", printable(sentence))
            print(f"heatlens: {printable(sentence)}", file=sys.stderr, flush=True)
        else:
            _message_counts[sentence] = _message_counts.get(sentence, 0) + 1
        if isinstance(sentence, Explained):
            LOG.debug("%s", printable(sentence.why))


@contextmanager
def gather_messages(shots: int) -> Iterator[None]:
    """Print each message of the block once, at its end, with the number of shots that it is about.

    `shots` is the number of all shots of the reel. Without this, the messages on each shot would
    fill the screen.
    """
    global _message_counts
    _message_counts = {}
    try:
        yield
    finally:
        message_counts, _message_counts = _message_counts, None
        for sentence, count in message_counts.items():
            shots_text = f"all {shots} shots" if count >= shots else f"{count} of {shots} shots"
            print_messages(sentence if count == 1 else f"{shots_text}: {sentence}")
