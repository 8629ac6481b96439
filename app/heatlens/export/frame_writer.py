"""Writing beside rendering: one thread, and a short queue before it."""

from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Generic, TypeVar

from heatlens.closing import Closing

Written = TypeVar("Written")

_WAITING = 2  # frames in memory that are rendered and not yet written, beside the one in hand


class FrameWriter(Closing, Generic[Written]):
    """Does what it is given in order, one at a time; what is finished comes back in that order.

    Left by an exception, it drops what has not begun and waits for what has.
    """

    def __init__(self) -> None:
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="frame-writer")
        self._pending: deque[Future[Written]] = deque()

    def put(self, write: Callable[[], Written]) -> Iterator[Written]:
        """Have `write` called; waits while too much is pending. Raises what writing raised."""
        self._pending.append(self._thread.submit(write))
        while self._pending and (len(self._pending) > _WAITING or self._pending[0].done()):
            yield self._pending.popleft().result()

    def drain(self) -> Iterator[Written]:
        """Wait for all that is pending."""
        while self._pending:
            yield self._pending.popleft().result()

    def close(self) -> None:
        """Drop what has not begun, and wait for what has."""
        self._thread.shutdown(wait=True, cancel_futures=True)
