"""How much time and memory a process may take that reads a file which may be damaged.

The system counts and ends the process: a library that never returns cannot count for itself. Time
is that of processors, so that an honest file is read on a busy machine too, and it grows with the
files that are read. A process that does not work at all, because it waits for a pipe or a disk
that never answers, has a longer bound by the clock.
"""

import contextlib
import math
import os
import signal
from pathlib import Path

SECONDS, GIGABYTES = "HEATLENS_USD_SECONDS", "HEATLENS_USD_GIGABYTES"
# OpenUSD itself takes nearly one of them.
SECONDS_MOST, GIGABYTES_MOST = 10.0, 3.0
SECONDS_A_MEGABYTE = 10.0  # of what is read: honest files of many small things take one or two
_CLOCK = 30.0  # by the clock that is so many times more: a busy machine gives little of a processor

TIME_SIGNALS = tuple(
    getattr(signal, name) for name in ("SIGXCPU", "SIGALRM") if hasattr(signal, name)
)

_allowed: dict[str, float] = {}  # seconds for each file; the key "" is what there is without any


def seconds_most() -> float:
    """Return the seconds of a processor that reading may take; each megabyte may take more."""
    return _told(SECONDS, SECONDS_MOST)


def gigabytes_most() -> float:
    """Return the addresses in memory that reading may take, in 1e9 bytes."""
    return _told(GIGABYTES, GIGABYTES_MOST)


def bound_this_process() -> None:
    """Have the system end this process where it takes more; Windows has no such bounds."""
    if os.name != "posix":
        return
    import resource

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    _lower(resource.RLIMIT_AS, int(gigabytes_most() * 1e9))
    _allowed[""] = seconds_most()
    _bound_time()


def allow_for(path: str | os.PathLike[str]) -> None:
    """Give a bounded process the time that the file at `path` may take; once for each file."""
    name = os.path.realpath(path)
    if not _allowed or name in _allowed:
        return
    with contextlib.suppress(OSError):  # who opens it says so
        _allowed[name] = Path(name).stat().st_size / 1e6 * SECONDS_A_MEGABYTE
        _bound_time()


def _bound_time() -> None:
    import resource

    seconds = math.ceil(sum(_allowed.values()))
    _lower(resource.RLIMIT_CPU, seconds)
    signal.setitimer(signal.ITIMER_REAL, _CLOCK * seconds)


def _lower(kind: int, most: int) -> None:
    """Set a limit of the system, unless the user's own is lower."""
    import resource

    _, hard = resource.getrlimit(kind)
    least = most if hard == resource.RLIM_INFINITY else min(most, hard)
    resource.setrlimit(kind, (least, hard))


def _told(name: str, most: float) -> float:
    """Return what the environment says where that is a number above 0, else `most`."""
    try:
        told = float(os.environ.get(name, most))
    except ValueError:
        return most
    return told if 0 < told < math.inf else most
