"""Note Ctrl-C, SIGTERM and a closed terminal, so that a loop can end in an orderly way.

While a loop sleeps in GLFW it is in a C function, where Python runs no signal handlers. Python's
own C handler still writes a byte into a pipe at once; a thread that reads it wakes the loop.
"""

import os
import signal
import threading
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Any

from heatlens.base import stopping


class StopSignals:
    """A context manager that records stop signals, so that none interrupts unfinished work."""

    def __init__(self, wake: Callable[[], None]) -> None:
        """Create it; `wake` is called on a thread after each signal."""
        self.number: int | None = None  # the signal that was received
        self._wake = wake
        self._before: dict[signal.Signals, Any] = {}
        self._hearing = stopping.hearing()

    def __enter__(self) -> "StopSignals":
        """Begin to listen; call this on the main thread."""
        for number in stopping.stop_signals():
            self._before[number] = signal.signal(number, self._note)
        read, self._write = os.pipe()
        os.set_blocking(self._write, False)
        self._pipe_before = signal.set_wakeup_fd(self._write, warn_on_full_buffer=False)
        threading.Thread(target=self._follow, args=(read,), daemon=True).start()
        self._hearing.__enter__()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Restore the previous signal handlers."""
        self._hearing.__exit__(kind, error, trace)
        signal.set_wakeup_fd(self._pipe_before)
        os.close(self._write)
        for number, before in self._before.items():
            signal.signal(number, before)

    def raise_if_stopped(self) -> None:
        """Raise Stopped if a signal has been received."""
        if self.number is not None:
            raise stopping.Stopped(self.number)

    def _note(self, number: int, _frame: FrameType | None) -> None:
        self.number = number

    def _follow(self, pipe: int) -> None:
        """Wake the loop for each byte until the pipe is closed; runs on a thread."""
        while os.read(pipe, 1):
            self._wake()
        os.close(pipe)
