"""Delay Ctrl-C while a library must not be interrupted.

moderngl builds programs in C and calls Python from there. It does not check for a KeyboardInterrupt
raised in such a call, and the process crashes. This is for notebooks and programs that import
heatlens; commands handle Ctrl-C in another way (`commands.launch`).
"""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Handle Ctrl-C after the block instead of inside it."""
    before = signal.getsignal(signal.SIGINT)
    # Only the main thread handles signals. None means a handler that was not set by Python.
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
