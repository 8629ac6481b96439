"""Requests for frames and their results, between a window and the thread that answers it."""

import queue
import threading
from collections.abc import Callable, Container, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass

from heatlens.deliver.farm.dask_types import Future
from heatlens.render.rendered_frames.cached_pictures import CachedPicture, RenderedPicture
from heatlens.render.rendered_frames.frame_filler import FrameJob


@dataclass(frozen=True)
class FrameRequest:
    """A frame that the window requests.

    key      identifies the frame among all requested ones
    make     returns its job; called on a thread, because it may look for files
    is_kept  True for a frame to be kept, in half floats; False for a picture that the user awaits
    """

    key: str
    make: Callable[[], FrameJob]
    is_kept: bool = True


@dataclass(frozen=True)
class FrameResult:
    """A frame that a worker has rendered, or the message of its failure."""

    key: str
    picture: RenderedPicture | CachedPicture | None
    problem: str = ""


# The window may not wait, so the lock is never held during a call that may wait for the network.
class FrameQueue:
    """The requests of one window, and the results that it has not collected yet."""

    def __init__(self, wake: Callable[[], None]) -> None:
        """Begin without requests; `wake` is called on a thread when there are results."""
        self._wake = wake
        self._lock = threading.Lock()  # guards the requests and the results
        self._requests: tuple[FrameRequest, ...] = ()
        self._results: list[FrameResult] = []
        self._urgent_request: FrameRequest | None = None  # the picture that the user awaits
        self._urgent_result: FrameResult | None = None
        self._signals: queue.SimpleQueue[Future | None] = queue.SimpleQueue()

    # Called by the window

    def request_frames(self, requests: Iterable[FrameRequest]) -> None:
        """Request these frames, in this order; all other frames are recalled."""
        with self._lock:
            self._requests = tuple(requests)
        self.signal(None)

    def request_urgent(self, request: FrameRequest | None) -> None:
        """Request this picture before all others; it replaces an earlier urgent request."""
        with self._lock:
            self._urgent_request, self._urgent_result = request, None
        self.signal(None)

    @property
    def urgent_result(self) -> FrameResult | None:
        """The result of the latest `request_urgent`; None until it has arrived."""
        with self._lock:
            return self._urgent_result

    def keep_requests(self, keys: Container[str]) -> None:
        """Recall all frames but those with these keys."""
        requests = [request for request in self.open_requests() if request.is_kept]
        kept_requests = [request for request in requests if request.key in keys]
        if len(kept_requests) != len(requests):
            self.request_frames(kept_requests)

    def collect_results(self) -> list[FrameResult]:
        """Return the results that have arrived since the last call, and forget them."""
        with self._lock:
            results, self._results = self._results, []
        return results

    # Called by the thread that has them rendered

    @property
    def uncollected_count(self) -> int:
        """The number of results that the window has not collected."""
        with self._lock:
            return len(self._results)

    def open_requests(self) -> tuple[FrameRequest, ...]:
        """Return the requests without a result, the urgent one first."""
        with self._lock:
            finished_keys = {it.key for it in self._results}
            urgent = () if self._urgent_request is None else (self._urgent_request,)
            return urgent + tuple(
                request for request in self._requests if request.key not in finished_keys
            )

    def signal(self, future: Future | None) -> None:
        """Wake the thread with a finished future, or with None to read the requests again."""
        self._signals.put(future)

    def wait_for_signals(self, seconds: float) -> list[Future | None]:
        """Return all signals since the last call, after waiting `seconds` at most for the first."""
        signals = []
        with suppress(queue.Empty):
            signals.append(self._signals.get(timeout=seconds))
            while True:
                signals.append(self._signals.get_nowait())
        return signals

    def deliver_results(self, results: Sequence[FrameResult]) -> None:
        """Hand results to the window, and remove their frames from the requests."""
        if results:
            by_key = {it.key: it for it in results}
            with self._lock:
                if self._urgent_request is not None and self._urgent_request.key in by_key:
                    self._urgent_result = by_key.pop(self._urgent_request.key)
                    self._urgent_request = None
                self._requests = tuple(it for it in self._requests if it.key not in by_key)
                self._results += by_key.values()
            self._wake()
