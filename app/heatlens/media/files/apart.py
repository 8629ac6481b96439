"""Call a function in a separate process, for libraries that crash on damaged files.

Run as a module, this calls the function that its arguments name with the pickled value of standard
input, and answers the calling process with its result. `limits` bounds its time and memory, because
a few thousand bytes can describe a scene of a billion objects. It never outlives the calling
process.

The answer has the pipe of standard output for itself. Libraries print there, names from the file
among the words, and what they print goes to standard error instead.
"""

import atexit
import importlib
import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import local
from typing import BinaryIO, TypeVar, cast

import heatlens
from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.base.faults import told_error
from heatlens.core.base.last_words import LastWords
from heatlens.core.base.stopping import end_with
from heatlens.media.files import limits
from heatlens.media.files.answers import AnswerError, packed, unpacked

Argument = TypeVar("Argument")
Result = TypeVar("Result")

_FAILED = 1  # exit code of Python for an uncaught error
_NO_MEMORY = 71  # EX_OSERR of sysexits.h, a system error

_running: set["subprocess.Popen[bytes]"] = set()
_of_thread = local()  # holds `stop` in threads that can be stopped


class Stop:
    """Stops the reading processes of another thread, both running ones and later ones."""

    def __init__(self) -> None:
        self._is_asked = False
        self._processes: set[subprocess.Popen[bytes]] = set()

    def ask(self) -> None:
        """Kill the running processes, and let later ones end at once."""
        self._is_asked = True
        for process in tuple(self._processes):
            process.kill()

    @contextmanager
    def heard(self) -> Iterator[None]:
        """Let this object stop the processes that this thread starts within the block."""
        _of_thread.stop = self
        try:
            yield
        finally:
            del _of_thread.stop

    def add(self, process: "subprocess.Popen[bytes]") -> None:
        """Kill `process` when a stop is asked for, or at once if it already was."""
        self._processes.add(process)
        if self._is_asked:
            process.kill()


# Draco, meshoptimizer, Basis Universal, libheif and OpenUSD unpack bytes of strangers in C, and
# OpenTimelineIO crashed or worked for ever on 8 of 8,000 damaged edits. A crash there ended the
# window. The process costs its start, so a whole scene shares one.
def called_apart(read: Callable[[Argument], Result], argument: Argument, what: str) -> Result:
    """Return `read(argument)`, computed in another process.

    `read` must be a function of a module in this package, with a picklable result. Raises the
    HeatlensError that it raises, and an InputError that begins with `what`, the name of the file,
    if the process crashes or exceeds its limits on time or memory.
    """
    names = (__spec__.name, str(os.getpid()), read.__module__, read.__name__, what)
    # -P: a file in the working folder that has the name of a Python module must not be run.
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", *names],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=_environment(),
    )
    _running.add(process)
    if hasattr(_of_thread, "stop"):
        _of_thread.stop.add(process)
    try:
        written, printed = _exchanged(process, pickle.dumps(argument))
    finally:
        _running.discard(process)
        process.kill()
    _check_end(process.returncode, printed, what)
    try:
        outcome = unpacked(written)
    except AnswerError as error:
        raise InputError(f"{what} cannot be read: {error}.") from error
    if isinstance(outcome, HeatlensError):
        raise outcome
    return cast(Result, outcome)


def _exchanged(process: "subprocess.Popen[bytes]", asked: bytes) -> tuple[bytes, str]:
    """Return the answer of `process` and the end of what it printed."""
    assert process.stdin is not None and process.stdout is not None
    printed = LastWords(process)
    with process:
        with suppress(BrokenPipeError):  # it ended early: its exit code tells why
            process.stdin.write(asked)
        with suppress(BrokenPipeError):
            process.stdin.close()
        written = process.stdout.read()
        process.wait()
        words = printed.text()
    return written, words


@atexit.register
def end_all() -> None:
    """Kill the processes that are still reading, because the program closes."""
    for process in tuple(_running):
        process.kill()


def _check_end(code: int, printed: str, what: str) -> None:
    """Raise an error for a process that ended with a `code` other than 0."""
    gigabytes = f"{limits.gigabytes_most():g} GB of memory"
    if code == _FAILED:
        raise told_error(RuntimeError(printed), f"{what}: not read")
    if -code in limits.TIME_SIGNALS:
        raise InputError(
            f"{what} cannot be read within {limits.seconds_most():g} s of processor time and "
            f"{limits.SECONDS_A_MEGABYTE:g} s for each megabyte: it is damaged, or has too many "
            f"parts. The variable {limits.SECONDS} allows more."
        )
    if code == _NO_MEMORY:
        raise InputError(
            f"{what} cannot be read within {gigabytes}: it is damaged, or has too many parts. The "
            f"variable {limits.GIGABYTES} allows more."
        )
    if code:
        raise InputError(
            f"{what} cannot be read: it is damaged in a way that crashes the library that reads "
            f"it, or needs more than {gigabytes} (the variable {limits.GIGABYTES} allows more)."
        )


def _environment() -> dict[str, str]:
    """Return the environment of this process, with the path to this package.

    Each thread of OpenUSD reserves memory; one thread for each of many cores would use all of it.
    """
    paths = [str(Path(heatlens.__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
    threads = {"PXR_WORK_THREAD_LIMIT": "4"}
    return threads | os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}


def _outcome(module: str, name: str, what: str) -> object:
    """Return the result of the function, or the HeatlensError that it raises or that reports it."""
    try:
        return getattr(importlib.import_module(module), name)(pickle.load(sys.stdin.buffer))
    except MemoryError:
        raise SystemExit(_NO_MEMORY) from None
    except HeatlensError as error:
        return error
    except Exception as error:
        return told_error(error, f"{what} could not be read")


def _answer_line() -> BinaryIO:
    """Return the pipe of standard output, and let all later output go to standard error.

    The descriptor changes, not only `sys.stdout`: libraries of C print too.
    """
    line = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    return line


def _answer(line: BinaryIO, outcome: object) -> None:
    """Send the answer."""
    try:
        with line:
            line.write(packed(outcome))
    except MemoryError:
        raise SystemExit(_NO_MEMORY) from None


if __name__ == "__main__":
    end_with(int(sys.argv[1]))
    answers = _answer_line()
    limits.bound_this_process()
    _answer(answers, _outcome(*sys.argv[2:]))
