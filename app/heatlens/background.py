"""Run work that would block the loop on a thread."""

from collections.abc import Callable
from concurrent.futures import Future
from threading import Thread
from typing import Generic, TypeVar

from heatlens.faults import told_error

Result = TypeVar("Result")


class Background(Generic[Result]):
    """Runs one job at a time; a newer one replaces the previous one, whose result is dropped.

    Its threads never prevent the program from ending, because a disk may not answer for minutes.
    """

    def __init__(self, wake: Callable[[], None]) -> None:
        """Set `wake`, which is called on the thread when the job has ended."""
        self._wake = wake
        self._coming: Future[Result] | None = None

    def start(self, job: Callable[[], Result]) -> None:
        """Start `job`, whose result must not be None."""
        coming: Future[Result] = Future()
        self._coming = coming
        Thread(target=_run, args=(job, coming, self._wake), daemon=True).start()

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

    def wait(self) -> None:
        """Wait until the job is done."""
        if self._coming is not None:
            self._coming.exception()


def _run(job: Callable[[], Result], coming: "Future[Result]", wake: Callable[[], None]) -> None:
    try:
        coming.set_result(job())
    except Exception as error:  # `poll` raises it in the loop, where it is reported
        coming.set_exception(told_error(error))
    wake()
