"""A call in a process of its own, for libraries that a damaged file brings to an end.

Run as a module it calls the function that its arguments name, and writes what became of it to its
standard output for the process that asked. It has a bound on its time and on its memory: a few
thousand bytes can describe a scene of a billion things.
"""

import importlib
import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import heatlens
from heatlens.errors import HeatlensError, InputError
from heatlens.faults import told_error

Result = TypeVar("Result")

_SECONDS, _GIGABYTES = "HEATLENS_USD_SECONDS", "HEATLENS_USD_GIGABYTES"
# OpenUSD itself takes nearly one of them.
_SECONDS_MOST, _GIGABYTES_MOST = 30.0, 3.0
_FAILED = 1  # Python's code for an error that nobody has caught
_NO_MEMORY = 71  # as sysexits.h calls an error of the system


def called_apart(read: Callable[[str], Result], text: str, what: str) -> Result:
    """Call `read(text)`, a function of this package, in another process; its result is pickled.

    Raises the HeatlensError that it raises, and an InputError that begins with `what`, the name of
    the file, where its process ends, or exceeds its bounds on time or memory.
    """
    # -P: a file beside the user's that is called like one of Python's must not be run.
    command = [sys.executable, "-P", "-m", __spec__.name, read.__module__, read.__name__, text]
    seconds, pipe = _limit(_SECONDS, _SECONDS_MOST), subprocess.PIPE
    try:
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            stdout=pipe,
            stderr=pipe,
            env=_environment(),
            timeout=seconds,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise InputError(
            f"{what} cannot be read within {seconds:g} s: it is damaged, or made of too many "
            f"things. {_SECONDS} allows more."
        ) from None
    _check_end(done, what)
    outcome: Result | HeatlensError = pickle.loads(done.stdout)
    if isinstance(outcome, HeatlensError):
        raise outcome
    return outcome


def _check_end(done: "subprocess.CompletedProcess[bytes]", what: str) -> None:
    """Raise what is to be said of a process that ended otherwise than it should."""
    if done.returncode == _FAILED:
        raise told_error(RuntimeError(done.stderr.decode(errors="replace")), f"{what}: not read")
    gigabytes = _limit(_GIGABYTES, _GIGABYTES_MOST)
    if done.returncode == _NO_MEMORY:
        raise InputError(
            f"{what} cannot be read within {gigabytes:g} GB of memory: it is damaged, or made of "
            f"too many things. {_GIGABYTES} allows more."
        )
    if done.returncode:
        raise InputError(
            f"{what} cannot be read: it is damaged in a way that crashes OpenUSD, or needs more "
            f"than {gigabytes:g} GB of memory ({_GIGABYTES} allows more)."
        )


def _limit(name: str, most: float) -> float:
    """Return the number in the environment where it is above 0, else `most`."""
    try:
        told = float(os.environ.get(name, most))
    except ValueError:
        return most
    return told if told > 0 else most


def _environment() -> dict[str, str]:
    """Return the environment of this process, with the path to this very package.

    Each thread of OpenUSD reserves memory: with one for each of many cores, none would be left.
    """
    paths = [str(Path(heatlens.__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
    threads = {"PXR_WORK_THREAD_LIMIT": "4"}
    return threads | os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}


def _outcome(module: str, name: str, text: str) -> object:
    """Return what the function returns, or the HeatlensError to raise in the caller."""
    try:
        return getattr(importlib.import_module(module), name)(text)
    except MemoryError:
        raise SystemExit(_NO_MEMORY) from None
    except HeatlensError as error:
        return error
    except Exception as error:
        return told_error(error, f"{text} could not be read")


def _bound_memory() -> None:
    """Have the system refuse more than that; Windows has no such bound for a process."""
    try:
        import resource
    except ImportError:
        return
    most = int(_limit(_GIGABYTES, _GIGABYTES_MOST) * 1e9)
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    if hard == resource.RLIM_INFINITY or hard > most:
        resource.setrlimit(resource.RLIMIT_AS, (most, hard))


def _written(outcome: object) -> bytes:
    try:
        return pickle.dumps(outcome)
    except MemoryError:
        raise SystemExit(_NO_MEMORY) from None


if __name__ == "__main__":
    _bound_memory()
    sys.stdout.buffer.write(_written(_outcome(*sys.argv[1:])))
