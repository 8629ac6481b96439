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

from heatlens.core.base.faults import to_heatlens_error

Result = TypeVar("Result")

_EXIT_WAIT_S = 2.0  # for threads that are at work when the program ends

_busy_threads: set[Thread] = set()  # threads of this module that have not ended


def has_busy_threads() -> bool:
    """Return True while any of these threads runs a job."""
    return bool(_busy_threads)


@atexit.register
def wait_for_busy_threads() -> None:
    """Let jobs end before Python shuts down, except those waiting for a disk that hangs.

    A thread that returned from a C++ library during shutdown would abort the process.
    """
    deadline = time.monotonic() + _EXIT_WAIT_S
    for thread in tuple(_busy_threads):
        thread.join(max(0.0, deadline - time.monotonic()))


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
        self._future: Future[Result] | None = None

    def start(self, job: Callable[[], Result]) -> None:
        """Start `job`, whose result must not be None, on a new thread."""
        self.cancel()
        future: Future[Result] = Future()
        _start_thread(lambda: _run_and_wake(job, future, self._wake), "background")
        self._future = future

    @property
    def is_busy(self) -> bool:
        """True while a job runs or its result has not been fetched."""
        return self._future is not None

    def poll(self) -> Result | None:
        """Return the result once when it is ready, else None.

        Raises HeatlensError, and nothing else, if the job failed for any reason.
        """
        future = self._future
        if future is None or not future.done():
            return None
        self._future = None
        return future.result()

    def cancel(self) -> None:
        """Forget the job, which goes on by itself; its result is dropped. Does not wait."""
        future, self._future = self._future, None
        if future is not None:
            future.add_done_callback(self._drop_result)

    def _drop_result(self, future: "Future[Result]") -> None:
        """Pass the result of a canceled job to `drop`; ignore a job that failed."""
        if future.exception() is None:
            self._drop(future.result())

    def wait(self) -> None:
        """Wait until the job is done."""
        if self._future is not None:
            self._future.exception()


class Threads:
    """Runs jobs in the order of `submit` on up to `most` threads, which end when they are idle."""

    def __init__(self, name: str, most: int = 1) -> None:
        """Create it without starting a thread; `name` is the name of its threads."""
        self._name = name
        self._thread_count_most = most
        self._lock = Lock()  # guards the fields below
        self._queued_jobs: deque[tuple[Future[Any], Callable[[], object]]] = deque()
        self._running_count = 0
        self._is_closed = False

    def submit(self, job: Callable[..., Result], *args: object) -> "Future[Result]":
        """Run `job(*args)` as soon as a thread is free, and return its future.

        Raises RuntimeError after `close`, and where the system allows no more threads.
        """
        future: Future[Result] = Future()
        with self._lock:
            if self._is_closed:
                raise RuntimeError(f"The threads {self._name} are closed.")
            if self._running_count < self._thread_count_most:
                _start_thread(self._work, self._name)
                self._running_count += 1
            self._queued_jobs.append((future, partial(job, *args)))
        return future

    def close(self) -> None:
        """Drop the jobs that have not begun, and return without waiting for those that have."""
        with self._lock:
            self._is_closed = True
            dropped_jobs, self._queued_jobs = self._queued_jobs, deque()
        for future, _ in dropped_jobs:
            future.cancel()

    def _work(self) -> None:
        """Run jobs until none is waiting; runs on a thread."""
        while (entry := self._pop_job()) is not None:
            _complete_future(*entry)

    def _pop_job(self) -> tuple["Future[object]", Callable[[], object]] | None:
        """Remove and return the oldest queued job; without one, count the thread as ended."""
        with self._lock:
            if self._queued_jobs:
                return self._queued_jobs.popleft()
            self._running_count -= 1
            return None


def _start_thread(work: Callable[[], None], name: str) -> None:
    """Run `work` on a new daemon thread, which counts as busy until `work` returns."""

    def run() -> None:
        """Do the work, and count the thread as idle afterwards."""
        try:
            work()
        finally:
            _busy_threads.discard(thread)

    thread = Thread(target=run, name=name, daemon=True)
    _busy_threads.add(thread)
    try:
        thread.start()
    except BaseException:
        _busy_threads.discard(thread)
        raise


def _run_and_wake(
    job: Callable[[], Result], future: "Future[Result]", wake: Callable[[], None]
) -> None:
    """Run `job`, put its result or its HeatlensError into `future`, and call `wake`."""
    try:
        future.set_result(job())
    except Exception as error:  # `poll` raises it in the loop, where it is reported
        future.set_exception(to_heatlens_error(error))
    wake()


def _complete_future(future: "Future[object]", job: Callable[[], object]) -> None:
    """Run `job` and put its result, or its exception, into `future`; skip a canceled one."""
    if not future.set_running_or_notify_cancel():
        return
    try:
        result = job()
    except BaseException as error:
        future.set_exception(error)
    else:
        future.set_result(result)
