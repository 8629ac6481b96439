"""Run work that would block the loop on threads that never hold up the end of the program.

A disk or a network folder may not answer for minutes. So these threads are daemon threads, and
nothing here waits for them unless it is asked to.
"""

import atexit
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from threading import Lock, Thread
from typing import Any, Generic, TypeVar

from heatlens.core.base.faults import told_error

Result = TypeVar("Result")

_PATIENCE_S = 2.0  # for threads that are at work when the program ends

_at_work: set[Thread] = set()


def is_at_work() -> bool:
    """Return True while any of these threads runs a job."""
    return bool(_at_work)


@atexit.register
def wait_a_moment() -> None:
    """Let jobs end before Python shuts down, except those waiting for a disk that hangs.

    A thread that returned from a C++ library during shutdown would abort the process.
    """
    end = time.monotonic() + _PATIENCE_S
    for thread in tuple(_at_work):
        thread.join(max(0.0, end - time.monotonic()))


class Background(Generic[Result]):
    """Runs one job at a time; a newer one replaces the previous one, whose result is dropped."""

    def __init__(
        self, wake: Callable[[], None], drop: Callable[[Result], None] = lambda result: None
    ) -> None:
        """Set `wake`, which is called on the thread when the job has ended.

        `drop` is called with each result that nobody wants any more, on the thread or in `cancel`.
        """
        self._wake = wake
        self._drop = drop
        self._coming: Future[Result] | None = None

    def start(self, job: Callable[[], Result]) -> None:
        """Start `job`, whose result must not be None, on a new thread."""
        self.cancel()
        coming: Future[Result] = Future()
        _start_thread(lambda: _run(job, coming, self._wake), "background")
        self._coming = coming

    @property
    def is_busy(self) -> bool:
        """True while a job runs or its result has not been fetched."""
        return self._coming is not None

    def poll(self) -> Result | None:
        """Return the result once when it is ready, else None.

        Raises HeatlensError, and nothing else, if the job failed for any reason.
        """
        coming = self._coming
        if coming is None or not coming.done():
            return None
        self._coming = None
        return coming.result()

    def cancel(self) -> None:
        """Forget the job, which goes on by itself; its result is dropped. Does not wait."""
        coming, self._coming = self._coming, None
        if coming is not None:
            coming.add_done_callback(self._dropped)

    def _dropped(self, coming: "Future[Result]") -> None:
        if coming.exception() is None:
            self._drop(coming.result())

    def wait(self) -> None:
        """Wait until the job is done."""
        if self._coming is not None:
            self._coming.exception()


class Threads:
    """Runs jobs in the order of `submit` on up to `most` threads, which end when they are idle."""

    def __init__(self, name: str, most: int = 1) -> None:
        """Create it without starting a thread; `name` is the name of its threads."""
        self._name = name
        self._most = most
        self._lock = Lock()  # guards the fields below
        self._waiting: deque[tuple[Future[Any], Callable[[], object]]] = deque()
        self._running = 0
        self._is_closed = False

    def submit(self, job: Callable[..., Result], *args: object) -> "Future[Result]":
        """Run `job(*args)` as soon as a thread is free, and return its future.

        Raises RuntimeError after `close`, and where the system allows no more threads.
        """
        coming: Future[Result] = Future()
        with self._lock:
            if self._is_closed:
                raise RuntimeError(f"The threads {self._name} are closed.")
            if self._running < self._most:
                _start_thread(self._work, self._name)
                self._running += 1
            self._waiting.append((coming, partial(job, *args)))
        return coming

    def close(self) -> None:
        """Drop the jobs that have not begun, and return without waiting for those that have."""
        with self._lock:
            self._is_closed = True
            dropped, self._waiting = self._waiting, deque()
        for coming, _ in dropped:
            coming.cancel()

    def _work(self) -> None:
        """Run jobs until none is waiting; runs on a thread."""
        while (entry := self._next()) is not None:
            _settle(*entry)

    def _next(self) -> tuple["Future[object]", Callable[[], object]] | None:
        with self._lock:
            if self._waiting:
                return self._waiting.popleft()
            self._running -= 1
            return None


def _start_thread(work: Callable[[], None], name: str) -> None:
    def run() -> None:
        try:
            work()
        finally:
            _at_work.discard(thread)

    thread = Thread(target=run, name=name, daemon=True)
    _at_work.add(thread)
    try:
        thread.start()
    except BaseException:
        _at_work.discard(thread)
        raise


def _run(job: Callable[[], Result], coming: "Future[Result]", wake: Callable[[], None]) -> None:
    try:
        coming.set_result(job())
    except Exception as error:  # `poll` raises it in the loop, where it is reported
        coming.set_exception(told_error(error))
    wake()


def _settle(coming: "Future[object]", job: Callable[[], object]) -> None:
    """Run `job` and put its result, or its exception, into `coming`."""
    try:
        result = job()
    except BaseException as error:
        coming.set_exception(error)
    else:
        coming.set_result(result)
