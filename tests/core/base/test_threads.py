"""Jobs on threads: a canceled one is skipped, also while another one runs."""

from concurrent.futures import Future
from threading import Event

from heatlens.core.base.background import Threads
from support.patience import PATIENCE_S


def test_canceled_jobs_are_skipped_and_the_thread_goes_on():
    threads, started, goes_on = Threads("jobs"), Event(), Event()

    def wait() -> str:
        started.set()
        goes_on.wait(PATIENCE_S)
        return "first"

    first, second = threads.submit(wait), threads.submit(lambda: "second")
    assert started.wait(PATIENCE_S)
    assert not first.cancel() and second.cancel()
    third: Future[str] = threads.submit(lambda: "third")
    goes_on.set()
    assert (first.result(PATIENCE_S), third.result(PATIENCE_S)) == ("first", "third")
    threads.close()
