"""A call in a process of its own, for libraries that a damaged file brings to an end.

Run as a module it calls the function that its arguments name, and writes what became of it to its
standard output for the process that asked. `limits` bounds its time and its memory: a few thousand
bytes can describe a scene of a billion things. It never outlives the process that asked.
"""

import atexit
import importlib
import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import local
from typing import TypeVar

import heatlens
from heatlens.errors import HeatlensError, InputError
from heatlens.faults import told_error
from heatlens.files import limits
from heatlens.stopping import end_with

Result = TypeVar("Result")

_FAILED = 1  # Python's code for an error that nobody has caught
_NO_MEMORY = 71  # as sysexits.h calls an error of the system

_running: set["subprocess.Popen[bytes]"] = set()
_of_thread = local()  # its `stop`, where it has one


class Stop:
    """Ends what another thread reads in processes of their own, now and from then on."""

    def __init__(self) -> None:
        self._is_asked = False
        self._processes: set[subprocess.Popen[bytes]] = set()

    def ask(self) -> None:
        """End them; a second call does nothing."""
        self._is_asked = True
        for process in tuple(self._processes):
            process.kill()

    @contextmanager
    def heard(self) -> Iterator[None]:
        """Let what this thread reads within the block be ended."""
        _of_thread.stop = self
        try:
            yield
        finally:
            del _of_thread.stop

    def add(self, process: "subprocess.Popen[bytes]") -> None:
        """End `process` when it is asked for, or at once where it was."""
        self._processes.add(process)
        if self._is_asked:
            process.kill()


def called_apart(read: Callable[[str], Result], text: str, what: str) -> Result:
    """Return `read(text)`, a function of a module of this package; its result must be picklable.

    Raises the HeatlensError that it raises, and an InputError that begins with `what`, the name of
    the file, where its process ends, or exceeds its bounds on time or memory.
    """
    names = (__spec__.name, str(os.getpid()), read.__module__, read.__name__, text)
    # -P: a file beside the user's that is called like one of Python's must not be run.
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", *names],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=_environment(),
    )
    _running.add(process)
    if hasattr(_of_thread, "stop"):
        _of_thread.stop.add(process)
    try:
        written, said = process.communicate()
    finally:
        _running.discard(process)
        process.kill()
    _check_end(process.returncode, said, what)
    outcome: Result | HeatlensError = pickle.loads(written)
    if isinstance(outcome, HeatlensError):
        raise outcome
    return outcome


@atexit.register
def end_all() -> None:
    """End what is still being read: nobody waits for it where the program closes."""
    for process in tuple(_running):
        process.kill()


def _check_end(code: int, said: bytes, what: str) -> None:
    """Raise what is to be said of a process that ended with a `code` other than 0."""
    gigabytes = f"{limits.gigabytes_most():g} GB of memory"
    if code == _FAILED:
        raise told_error(RuntimeError(said.decode(errors="replace")), f"{what}: not read")
    if -code in limits.TIME_SIGNALS:
        raise InputError(
            f"{what} cannot be read within {limits.seconds_most():g} s of a processor and "
            f"{limits.SECONDS_A_MEGABYTE:g} s for each megabyte: it is damaged, or made of too "
            f"many things. {limits.SECONDS} allows more."
        )
    if code == _NO_MEMORY:
        raise InputError(
            f"{what} cannot be read within {gigabytes}: it is damaged, or made of too many "
            f"things. {limits.GIGABYTES} allows more."
        )
    if code:
        raise InputError(
            f"{what} cannot be read: it is damaged in a way that crashes OpenUSD, or needs more "
            f"than {gigabytes} ({limits.GIGABYTES} allows more)."
        )


def _environment() -> dict[str, str]:
    """Return the environment of this process, with the path to this very package.

    Each thread of OpenUSD sets memory aside: with one for each of many cores, none would be left.
    """
    paths = [str(Path(heatlens.__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
    threads = {"PXR_WORK_THREAD_LIMIT": "4"}
    return threads | os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}


def _outcome(module: str, name: str, text: str) -> object:
    """Return what the function gives, or the HeatlensError that it raises or that is to be told."""
    try:
        return getattr(importlib.import_module(module), name)(text)
    except MemoryError:
        raise SystemExit(_NO_MEMORY) from None
    except HeatlensError as error:
        return error
    except Exception as error:
        return told_error(error, f"{text} could not be read")


def _written(outcome: object) -> bytes:
    try:
        return pickle.dumps(outcome)
    except MemoryError:
        raise SystemExit(_NO_MEMORY) from None


if __name__ == "__main__":
    end_with(int(sys.argv[1]))
    limits.bound_this_process()
    sys.stdout.buffer.write(_written(_outcome(*sys.argv[2:])))
