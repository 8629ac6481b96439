"""Call a function in a separate process, for libraries that crash on damaged files.

Run as a module, this calls the function that its arguments name with the pickled value of standard
input, and sends the result to the calling process. `limits` bounds its time and memory, because a
few thousand bytes can describe a scene of a billion objects. It never outlives the calling process.

The pipe of standard output is reserved for the answer. Whatever libraries print there, which may
contain names from the file, goes to standard error instead.
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
from heatlens.core.base.faults import to_heatlens_error
from heatlens.core.base.last_words import StderrTail
from heatlens.core.base.own_command import module_command
from heatlens.core.base.stopping import die_with_parent
from heatlens.media.files import limits
from heatlens.media.files.answers import AnswerError, pack_answer, unpack_answer

Argument = TypeVar("Argument")
Result = TypeVar("Result")

_FAILED = 1  # exit code of Python for an uncaught error
_NO_MEMORY = 71  # EX_OSERR of sysexits.h, a system error

_running_processes: set["subprocess.Popen[bytes]"] = set()
_thread_values = local()  # holds `stop` in threads that can be stopped


class Stop:
    """Stops the reading processes of another thread, both running ones and later ones."""

    def __init__(self) -> None:
        self._is_requested = False
        self._processes: set[subprocess.Popen[bytes]] = set()

    def request(self) -> None:
        """Kill the running processes, and let later ones end at once."""
        self._is_requested = True
        for process in tuple(self._processes):
            process.kill()

    @contextmanager
    def applies_to_thread(self) -> Iterator[None]:
        """Let this object stop the processes that this thread starts within the block."""
        _thread_values.stop = self
        try:
            yield
        finally:
            del _thread_values.stop

    def add(self, process: "subprocess.Popen[bytes]") -> None:
        """Kill `process` when a stop is asked for, or at once if it already was."""
        self._processes.add(process)
        if self._is_requested:
            process.kill()


# A separate process keeps a crash of a library from ending the window. Draco, meshoptimizer, Basis
# Universal, libheif and OpenUSD unpack bytes of strangers in C; OpenTimelineIO crashed or never
# ended on 8 of 8,000 damaged edits. Starting a process takes time, so a whole scene shares one.
def call_in_process(
    read: Callable[[Argument], Result], argument: Argument, file_name: str
) -> Result:
    """Return `read(argument)`, computed in another process.

    `read` must be a function of a module in this package, with a picklable result. Raises the
    HeatlensError that it raises, and an InputError that begins with `file_name` if the process
    crashes or exceeds its limits on time or memory.
    """
    words = (str(os.getpid()), read.__module__, read.__name__, file_name)
    process = subprocess.Popen(
        module_command(__spec__.name, *words),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=_environment(),
    )
    _running_processes.add(process)
    if hasattr(_thread_values, "stop"):
        _thread_values.stop.add(process)
    try:
        answer, error_text = _exchange(process, pickle.dumps(argument))
    finally:
        _running_processes.discard(process)
        process.kill()
    _check_exit_code(process.returncode, error_text, file_name)
    try:
        outcome = unpack_answer(answer)
    except AnswerError as error:
        raise InputError(f"{file_name} cannot be read: {error}.") from error
    if isinstance(outcome, HeatlensError):
        raise outcome
    return cast(Result, outcome)


def _exchange(process: "subprocess.Popen[bytes]", argument: bytes) -> tuple[bytes, str]:
    """Send the pickled argument to `process`; return its answer and the end of its error output."""
    assert process.stdin is not None and process.stdout is not None
    stderr_tail = StderrTail(process)
    with process:
        with suppress(BrokenPipeError):  # it ended early: its exit code tells why
            process.stdin.write(argument)
        with suppress(BrokenPipeError):
            process.stdin.close()
        answer = process.stdout.read()
        process.wait()
        error_text = stderr_tail.text()
    return answer, error_text


@atexit.register
def kill_reading_processes() -> None:
    """Kill the processes that are still reading, because the program closes."""
    for process in tuple(_running_processes):
        process.kill()


def _check_exit_code(exit_code: int, error_text: str, file_name: str) -> None:
    """Raise an error for a process that ended with an `exit_code` other than 0."""
    gigabytes = f"{limits.gigabytes_most():g} GB of memory"
    if exit_code == _FAILED:
        raise to_heatlens_error(RuntimeError(error_text), f"{file_name}: not read")
    if limits.is_time_exit(exit_code):
        raise InputError(
            f"{file_name} cannot be read within {limits.seconds_most():g} s of processor time and "
            f"{limits.SECONDS_A_MEGABYTE:g} s for each megabyte: it is damaged, or has too many "
            f"parts. The variable {limits.SECONDS} allows more."
        )
    if exit_code == _NO_MEMORY:
        raise InputError(
            f"{file_name} cannot be read within {gigabytes}: it is damaged, or has too many "
            "parts. The "
            f"variable {limits.GIGABYTES} allows more."
        )
    if exit_code:
        raise InputError(
            f"{file_name} cannot be read: it is damaged in a way that crashes the library that "
            "reads "
            f"it, or needs more than {gigabytes} (the variable {limits.GIGABYTES} allows more)."
        )


def _environment() -> dict[str, str]:
    """Return the environment of this process, with the path to this package.

    Each thread of OpenUSD reserves memory; one thread for each of many cores would use all of it.
    """
    paths = [str(Path(heatlens.__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
    threads = {"PXR_WORK_THREAD_LIMIT": "4"}
    return threads | os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}


def _call_by_name(module: str, function_name: str, file_name: str) -> object:
    """Return the result of the function, or the HeatlensError that describes its failure."""
    try:
        return getattr(importlib.import_module(module), function_name)(
            pickle.load(sys.stdin.buffer)
        )
    except MemoryError:
        raise SystemExit(_NO_MEMORY) from None
    except HeatlensError as error:
        return error
    except Exception as error:
        return to_heatlens_error(error, f"{file_name} could not be read")


def _claim_stdout() -> BinaryIO:
    """Return the pipe of standard output, and redirect all later output to standard error.

    The descriptor changes, not only `sys.stdout`: libraries of C print too.
    """
    pipe = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    return pipe


def _send_answer(pipe: BinaryIO, outcome: object) -> None:
    """Write the packed outcome to the pipe and close it. Raises SystemExit."""
    try:
        with pipe:
            pipe.write(pack_answer(outcome))
    except MemoryError:
        raise SystemExit(_NO_MEMORY) from None


if __name__ == "__main__":
    die_with_parent(int(sys.argv[1]))
    answers = _claim_stdout()
    limits.bound_this_process()
    _send_answer(answers, _call_by_name(*sys.argv[2:]))
