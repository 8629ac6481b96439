"""Ctrl-C held back while a library is in the middle of something.

moderngl builds programs in C and calls Python from there. A KeyboardInterrupt that is raised in
such a call is not looked for, and the process ends in a crash. Commands do not hear Ctrl-C at all
(`commands.launch`); this is for notebooks and programs that import heatlens.
"""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Answer Ctrl-C after the block instead of inside it."""
    before = signal.getsignal(signal.SIGINT)
    # Only the main thread answers signals. None stands for a handler that Python did not set.
    if threading.current_thread() is not threading.main_thread() or before is None:
        yield
        return
    arrived: list[FrameType | None] = []
    signal.signal(signal.SIGINT, lambda _number, frame: arrived.append(frame))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
        if arrived and callable(before):
            before(signal.SIGINT, arrived[0])
