"""Jobs on threads: a canceled one is skipped, also while another one runs."""

from concurrent.futures import Future
from threading import Event

from heatlens.core.base.background import Threads


def test_canceled_jobs_are_skipped_and_the_thread_goes_on():
    threads, started, goes_on = Threads("jobs"), Event(), Event()

    def wait() -> str:
        started.set()
        goes_on.wait(60.0)
        return "first"

    first, second = threads.submit(wait), threads.submit(lambda: "second")
    assert started.wait(60.0)
    assert not first.cancel() and second.cancel()
    third: Future[str] = threads.submit(lambda: "third")
    goes_on.set()
    assert (first.result(60.0), third.result(60.0)) == ("first", "third")
    threads.close()
