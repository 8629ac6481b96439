"""Run a command in a worker process on Linux, while the process that the user started waits.

Ctrl-C must take effect at once, whatever the command is doing. Drivers and libraries do not allow
that: an interrupt during one of their calls is handled only when the call returns, many seconds
later, appears as a wrong error ("cannot be loaded"), or causes a crash. So the worker ignores
Ctrl-C. This process handles it: it kills the worker, removes its unfinished files, and prints a
message. The window, which has to save state, asks to receive the signal instead
(`stopping.handle_own_signals`).

This process also reports when a fault in a driver or a library ended the worker.
"""

import os
import signal
import sys
import time
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

from heatlens.core.base import stopping
from heatlens.core.base.errors import FAULT_CODE

assert sys.platform == "linux"  # so that type checkers for other systems skip the rest

_STOP_TIMEOUT_S = 3.0  # time for a worker that handles signals itself to finish its current step


def run_in_worker(run_command: Callable[[], int]) -> int:
    """Call `run_command` in a worker process; return its exit code here and there."""
    stops = stopping.stop_signals()
    old_mask = signal.pthread_sigmask(signal.SIG_BLOCK, {*stops, signal.SIGCHLD})
    record, parent = os.memfd_create("heatlens"), os.getpid()
    worker = os.fork()
    if worker == 0:
        for stop in stops:
            signal.signal(stop, signal.SIG_IGN)
        signal.pthread_sigmask(signal.SIG_SETMASK, old_mask)
        stopping.die_with_parent(parent)
        stopping.begin_record(partial(os.write, record))
        return run_command()
    return _wait_for_worker(worker, stops, record)


def _read_record(record: int) -> stopping.LeftoverFiles:
    """Read the file in memory that the worker writes, by its descriptor."""
    return stopping.read_record(os.pread(record, os.fstat(record).st_size, 0))


def _wait_for_worker(worker: int, stops: frozenset[signal.Signals], record: int) -> int:
    """Wait until the worker has ended or must be ended; return the exit code."""
    while True:
        received = signal.sigwait({*stops, signal.SIGCHLD})
        ended_process, status = os.waitpid(worker, os.WNOHANG)
        if ended_process:
            return _report_end(os.waitstatus_to_exitcode(status), record)
        if received in stops:
            return _stop_worker(worker, signal.Signals(received), record)


def _stop_worker(worker: int, stop_signal: signal.Signals, record: int) -> int:
    """End the worker, remove its unfinished files, and report it unless the worker did.

    Returns the exit code.
    """
    code = _pass_signal_on(worker, stop_signal) if _read_record(record).handles_signals else None
    if code is not None and code >= 0:
        return code
    if code is None:
        os.kill(worker, signal.SIGSTOP)  # so that it starts no more children while they are listed
        for process in (worker, *_descendants(worker)):
            _kill(process)
        os.waitpid(worker, 0)
    leftovers = _read_record(record)
    stopping.remove_leftovers(leftovers)
    if not leftovers.has_reported_stop:
        _print_message("stopped")
    return 128 + stop_signal


def _pass_signal_on(worker: int, stop_signal: signal.Signals) -> int | None:
    """Pass the signal on; return the worker's exit code, or None if it does not end in time.

    A second signal from the user ends the waiting.
    """
    os.kill(worker, stop_signal)
    deadline = time.monotonic() + _STOP_TIMEOUT_S
    while (left_s := deadline - time.monotonic()) > 0:
        received = signal.sigtimedwait({signal.SIGCHLD, signal.SIGINT, signal.SIGTERM}, left_s)
        ended_process, status = os.waitpid(worker, os.WNOHANG)
        if ended_process:
            return os.waitstatus_to_exitcode(status)
        if received is not None and received.si_signo != signal.SIGCHLD:
            return None
    return None


def _report_end(code: int, record: int) -> int:
    """Return the exit code of this process for the worker's code, and report a crash or kill.

    The worker's code is negative if a signal ended it.
    """
    if code >= 0:
        return code
    stopping.remove_leftovers(_read_record(record))
    name = signal.Signals(-code).name
    if -code in (signal.SIGSEGV, signal.SIGBUS, signal.SIGABRT, signal.SIGFPE, signal.SIGILL):
        _print_message(
            f"a fault in the graphics driver or in a library ended the work ({name}). "
            "`heatlens doctor` checks this machine."
        )
        return FAULT_CODE
    if -code == signal.SIGKILL:
        _print_message("the work was killed from outside, as systems do when memory runs out")
    return 128 - code


def _descendants(process: int) -> Iterable[int]:
    """Yield the processes that `process` started, and those that they started."""
    for tasks in Path(f"/proc/{process}/task").glob("*/children"):
        try:
            children = [int(word) for word in tasks.read_text(encoding="utf-8").split()]
        except OSError:  # the thread has ended meanwhile
            continue
        for child in children:
            yield child
            yield from _descendants(child)


def _kill(process: int) -> None:
    """Kill a process by its number, if it still runs."""
    try:
        os.kill(process, signal.SIGKILL)
    except ProcessLookupError:
        return  # it ended by itself


def _print_message(message: str) -> None:
    """Print a message, over any line of progress that the worker left on the terminal."""
    clear_line = "\r\x1b[K" if sys.stderr.isatty() else ""
    sys.stderr.write(f"{clear_line}heatlens: {message}\n")
    sys.stderr.flush()
