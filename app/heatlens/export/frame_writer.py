"""Write frames on a thread with a short queue while the next ones are rendered."""

from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Generic, TypeVar

from heatlens.base.closing import Closing

Written = TypeVar("Written")

_WAITING = 2  # rendered frames that may wait in memory, besides the one being written


class FrameWriter(Closing, Generic[Written]):
    """Runs functions on a thread in order, one at a time, and returns their results in order.

    If its context is left by an exception, pending functions are dropped and a running one is
    awaited.
    """

    def __init__(self) -> None:
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="frame-writer")
        self._pending: deque[Future[Written]] = deque()

    def put(self, write: Callable[[], Written]) -> Iterator[Written]:
        """Queue `write`; yield finished results, and wait if too many are pending.

        Raises the errors of writing.
        """
        self._pending.append(self._thread.submit(write))
        while self._pending and (len(self._pending) > _WAITING or self._pending[0].done()):
            yield self._pending.popleft().result()

    def drain(self) -> Iterator[Written]:
        """Wait for all pending functions, and yield their results."""
        while self._pending:
            yield self._pending.popleft().result()

    def close(self) -> None:
        """Drop pending functions, and wait for a running one."""
        self._thread.shutdown(wait=True, cancel_futures=True)
