"""Work that would hold up the loop, on a thread of its own."""

from collections.abc import Callable
from concurrent.futures import Future
from threading import Thread
from typing import Generic, TypeVar

from heatlens.faults import told_error

Result = TypeVar("Result")


class Background(Generic[Result]):
    """One job at a time; a newer one takes the place of the one before, whose result is lost.

    Its threads never keep the program from ending: a disk may not answer for minutes.
    """

    def __init__(self, wake: Callable[[], None]) -> None:
        """Take `wake`, which is called on the thread when the job has ended."""
        self._wake = wake
        self._coming: Future[Result] | None = None

    def start(self, job: Callable[[], Result]) -> None:
        """Begin `job`, whose result is something other than None."""
        coming: Future[Result] = Future()
        self._coming = coming
        Thread(target=_run, args=(job, coming, self._wake), daemon=True).start()

    @property
    def is_busy(self) -> bool:
        """A job goes on, or its result was not asked for yet."""
        return self._coming is not None

    def poll(self) -> Result | None:
        """Return the result, once, when it is there.

        Raises HeatlensError, and nothing else, where the job failed in whatever way.
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
    except Exception as error:  # `poll` raises it in the loop, where it is said
        coming.set_exception(told_error(error))
    wake()
