"""Ctrl-C in the terminal and SIGTERM, as something that the window's loop can ask about.

A loop that sleeps in GLFW is in a C function, where Python answers no signal. Python's own C
handler writes a byte into a pipe, though, whatever the program is in the middle of; a thread that
reads from it wakes the loop.
"""

import os
import signal
import threading
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Any

from heatlens import stopping

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class StopSignals:
    """While open, stop signals are noted instead of falling into the middle of the work."""

    def __init__(self, wake: Callable[[], None]) -> None:
        """Take `wake`, which is called on a thread after each signal."""
        self.number: int | None = None  # of the signal that asked to stop
        self._wake = wake
        self._before: dict[signal.Signals, Any] = {}
        self._hearing = stopping.hearing()

    def __enter__(self) -> "StopSignals":
        """Begin to listen; to be called on the main thread."""
        for number in _SIGNALS:
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
        """Let signals do what they did before."""
        self._hearing.__exit__(kind, error, trace)
        signal.set_wakeup_fd(self._pipe_before)
        os.close(self._write)
        for number, before in self._before.items():
            signal.signal(number, before)

    def raise_if_stopped(self) -> None:
        """Raise Stopped where a signal has come."""
        if self.number is not None:
            raise stopping.Stopped(self.number)

    def _note(self, number: int, _frame: FrameType | None) -> None:
        self.number = number

    def _follow(self, pipe: int) -> None:
        """Wake the loop for each byte until the other end is closed; on a thread."""
        while os.read(pipe, 1):
            self._wake()
        os.close(pipe)
