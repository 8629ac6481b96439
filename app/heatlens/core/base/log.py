"""What was decided, why, and how long it took: for `--verbose`, and for the file of HEATLENS_LOG.

Messages to the user are of the level INFO, what is behind them DEBUG, and refusals ERROR. Processes
that heatlens starts append to the same file. It holds names of files and no pixels.
"""

import logging
import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from heatlens.core.base.errors import InputError
from heatlens.core.base.outside_text import printable
from heatlens.version import __version__

FILE_VARIABLE = "HEATLENS_LOG"  # names the file to which everything is appended
LOG = logging.getLogger("heatlens")
LOG.addHandler(logging.NullHandler())
LOG.propagate = False
_LINE = "%(asctime)s %(process)d %(levelname)s %(message)s"


def start_log(is_verbose: bool) -> None:
    """Begin the log: on stderr if `is_verbose`, and in the file of HEATLENS_LOG if it is set.

    Raises InputError if the file cannot be written.
    """
    handlers: list[logging.Handler] = [logging.NullHandler()]
    if is_verbose:
        terminal = logging.StreamHandler(sys.stderr)
        terminal.setFormatter(logging.Formatter("heatlens: %(message)s"))
        terminal.addFilter(lambda record: record.levelno == logging.DEBUG)  # others are printed
        handlers.append(terminal)
    if path := os.environ.get(FILE_VARIABLE):
        try:
            handlers.append(logging.FileHandler(path, encoding="utf-8"))
        except OSError as error:
            raise InputError(
                f"{FILE_VARIABLE}={path}: the log cannot be written there "
                f"({error.strerror}). Name another file."
            ) from None
        handlers[-1].setFormatter(logging.Formatter(_LINE))
    for handler in LOG.handlers:  # of an earlier command in this process
        handler.close()
    LOG.handlers[:] = handlers
    is_kept = len(handlers) > 1
    LOG.setLevel(logging.DEBUG if is_kept else logging.CRITICAL)
    if is_kept:
        _log_beginning()


@contextmanager
def log_time(what: str) -> Iterator[None]:
    """Log how long the block took, of which `what` says what it does."""
    begun_s = time.perf_counter()
    yield
    LOG.debug("%s: %.3f s", printable(what), time.perf_counter() - begun_s)


def log_end(code: int) -> None:
    """Log with which exit code the command ends, and after how long."""
    LOG.debug("ended with %d after %.2f s", code, time.perf_counter() - _BEGUN_S)


def _log_beginning() -> None:
    """Log the versions and the command."""
    import platform  # slow, and few commands keep a log

    version = platform.python_version()
    LOG.debug("heatlens %s, Python %s, %s", __version__, version, platform.platform())
    LOG.debug("command: %s", printable(" ".join(sys.argv)))


_BEGUN_S = time.perf_counter()
