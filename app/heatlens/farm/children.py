"""Start the heatlens command as processes beside this one, and stop them."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from threading import Thread, current_thread, main_thread

PATIENCE_S = 2.0  # time to stop before a process is killed
_STOPS = (signal.SIGINT, signal.SIGTERM)


def started(
    words: Sequence[str], is_shown: bool = False, count: int = 1
) -> "subprocess.Popen[str]":
    """Start the heatlens command with these words as a process, one of `count` at work.

    If `is_shown`, it prints here.
    """
    # -P: do not run a file in the current folder that has the name of a Python module.
    line = [sys.executable, "-P", "-m", "heatlens", *words]
    with _signals_heard_by_children():
        pipe = None if is_shown else subprocess.PIPE
        environment = _share_of_processors(count) | os.environ
        return subprocess.Popen(line, stdout=pipe, stderr=pipe, text=True, env=environment)


def _share_of_processors(count: int) -> dict[str, str]:
    """Return the number of threads for Mesa's software rasteriser, which else takes all processors.

    With more threads than processors, each pass waits for the slowest of them.
    """
    threads = max(1, (os.cpu_count() or 1) // count)
    return {"LP_NUM_THREADS": str(threads)} if count > 1 else {}


@contextmanager
def _signals_heard_by_children() -> Iterator[None]:
    """Start processes that obey stop signals, even if this process ignores them.

    A child inherits ignored signals, for example from `heatlens x &` in a script; a signal with a
    handler has its usual effect in the child. Only the main thread may set handlers.
    """
    if current_thread() is not main_thread():
        yield
        return
    ignored = [number for number in _STOPS if signal.getsignal(number) is signal.SIG_IGN]
    for number in ignored:
        signal.signal(number, lambda *_: None)
    try:
        yield
    finally:
        for number in ignored:
            signal.signal(number, signal.SIG_IGN)


def stop(process: "subprocess.Popen[str]", how: signal.Signals = signal.SIGTERM) -> None:
    """Ask `process` to stop; kill it after a while if it has not."""
    process.send_signal(how)  # SIGTERM works from the first moment on, unlike Ctrl-C
    Thread(target=_kill_late, args=(process,), daemon=True).start()


def _kill_late(process: "subprocess.Popen[str]") -> None:
    """Kill a process that was asked to stop and still runs; runs on a thread."""
    try:
        process.wait(PATIENCE_S)
    except subprocess.TimeoutExpired:
        process.kill()
