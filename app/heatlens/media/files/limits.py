"""Limit the time and memory of a process that reads a file which may be damaged.

The operating system enforces the limits, because a library that never returns cannot do so itself.
They count processor time, so that a valid file can be read on a busy machine too, and grow with
the size of the files. A process that only waits, for a pipe or a disk that never answers, has a
longer limit of elapsed time.
"""

import contextlib
import math
import os
import signal
import sys
import threading
from pathlib import Path

if sys.platform == "win32":
    from heatlens.core.base.windows_calls import TIME_EXIT_CODE, ProcessLimits

SECONDS, GIGABYTES = "HEATLENS_READING_SECONDS", "HEATLENS_READING_GIGABYTES"
# The default limits; OpenUSD itself takes nearly a gigabyte.
SECONDS_MOST, GIGABYTES_MOST = 10.0, 3.0
SECONDS_A_MEGABYTE = 10.0  # valid files of many small objects take one or two
_ELAPSED_FACTOR = 30.0  # elapsed time may be this many times the processor time, on a busy machine

_allowed: dict[str, float] = {}  # seconds for each file; the key "" holds the basic allowance
if sys.platform == "win32":
    _process_limits: list[ProcessLimits] = []  # of a bounded process


def seconds_most() -> float:
    """Return the processor time in seconds that reading may take, besides that per megabyte."""
    return _from_environment(SECONDS, SECONDS_MOST)


def gigabytes_most() -> float:
    """Return the address space that reading may take, in units of 1e9 bytes."""
    return _from_environment(GIGABYTES, GIGABYTES_MOST)


def is_bounded() -> bool:
    """Return True in a process that reads a file for another process."""
    return bool(_allowed)


def is_time_exit(exit_code: int) -> bool:
    """Return whether a process with this exit code, negative for a signal, took all its time."""
    if sys.platform == "win32":
        return exit_code == TIME_EXIT_CODE
    return -exit_code in (signal.SIGXCPU, signal.SIGALRM)


def bound_this_process() -> None:
    """Let the system end this process if it exceeds the limits."""
    _allowed[""] = seconds_most()
    if sys.platform == "win32":
        _process_limits.append(ProcessLimits())
        _bound_time()
        return
    import resource

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    _lower_limit(resource.RLIMIT_AS, int(gigabytes_most() * 1e9))
    _bound_time()


def allow_for(path: str | os.PathLike[str]) -> None:
    """Extend the time limit of a bounded process for the file at `path`, once for each file."""
    name = os.path.realpath(path)
    if not _allowed or name in _allowed:
        return
    with contextlib.suppress(OSError):  # the code that opens the file reports the error
        _allowed[name] = Path(name).stat().st_size / 1e6 * SECONDS_A_MEGABYTE
        _bound_time()


def _bound_time() -> None:
    """Set the limits of processor time and of elapsed time from the allowed seconds."""
    seconds = math.ceil(sum(_allowed.values()))
    if sys.platform == "win32":
        _process_limits[0].set(seconds, int(gigabytes_most() * 1e9))
        _watch_elapsed(_ELAPSED_FACTOR * seconds)
        return
    import resource

    _lower_limit(resource.RLIMIT_CPU, seconds)
    signal.setitimer(signal.ITIMER_REAL, _ELAPSED_FACTOR * seconds)


def _watch_elapsed(seconds: float) -> None:
    """End this process after `seconds`, on Windows, where no timer of the system does."""
    if sys.platform == "win32":
        timer = threading.Timer(seconds, os._exit, (TIME_EXIT_CODE,))
        timer.daemon = True
        timer.start()


def _lower_limit(kind: int, limit: int) -> None:
    """Set a soft resource limit, but never above the hard limit of this process."""
    if sys.platform == "win32":
        return
    import resource

    _, hard = resource.getrlimit(kind)
    lower_limit = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
    resource.setrlimit(kind, (lower_limit, hard))


def _from_environment(name: str, default: float) -> float:
    """Return the number in an environment variable if it is finite and above 0, else `default`."""
    try:
        value = float(os.environ.get(name, default))
    except ValueError:
        return default
    return value if 0 < value < math.inf else default
