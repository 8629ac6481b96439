"""Have frames rendered for the window by the workers of a Dask cluster.

A thread speaks with the scheduler, so that no method waits for the network.
"""

import queue
import threading
import time
from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass

from heatlens.core.base.background import Threads
from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.base.faults import to_heatlens_error
from heatlens.deliver.farm.answers import answer_of
from heatlens.deliver.farm.connection import SchedulerIdentity, connected, is_loss, not_data_error
from heatlens.deliver.farm.dask_types import Client, Future
from heatlens.deliver.farm.data_only import NotDataError
from heatlens.deliver.farm.frame_worker import (
    Program,
    answer_frame,
    answer_program,
    job_to_send,
    own_program,
    picture_of_answer,
    program_of_answer,
)
from heatlens.render.defocus.line_solver import SolverName
from heatlens.render.rendered_frames.cached_pictures import CachedPicture, RenderedPicture
from heatlens.render.rendered_frames.frame_filler import FrameJob

_WORKER_CHECK_S = 1.0  # interval between checks for new and lost workers
_RETRY_S = 10.0  # after a failure, time until the scheduler is tried again
_FRAMES_PER_WORKER = 2  # frames that each worker has, so that none waits for the next
_URGENT_PRIORITY = 10  # priority of a picture that somebody waits for

ON_THIS_MACHINE = "Frames are rendered on this machine."


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


# Every call of Dask's client may wait for the network, or for a scheduler that has gone, and a
# window may not wait. So one thread alone has the client; the window writes requests and reads
# results under a lock that is never held during a call.
class FrameCluster:
    """The frames of one window at one scheduler."""

    def __init__(
        self,
        address: str,
        own_driver: tuple[str, str, SolverName],
        wake: Callable[[], None],
        confirmed: SchedulerIdentity | None = None,
    ) -> None:
        """Begin to connect.

        `own_driver` is the graphics driver of the window, its version, and the solver. `wake` is
        called on a thread when there are results or a new status. No other scheduler or network is
        used than that of `confirmed` before `confirm_scheduler` is called.
        """
        self.address, self.own_driver = address, own_driver
        self.unconfirmed: SchedulerIdentity | None = (
            None  # the scheduler that answers, until the user confirms it
        )
        self._confirmed = confirmed
        self.workers: tuple[str, ...] = ()  # addresses of the workers that render
        self.problem = ""  # message why no worker renders, or ""
        self.program: Program = ()  # program of the workers, if it is not that of this machine
        self._wake = wake
        self._lock = threading.Lock()  # guards the requests and the results
        self._requests: tuple[FrameRequest, ...] = ()
        self._results: list[FrameResult] = []
        self._urgent_request: FrameRequest | None = None  # the picture that the user awaits
        self._urgent_result: FrameResult | None = None
        self._signals: queue.SimpleQueue[Future | None] = queue.SimpleQueue()
        self._closed = threading.Event()
        self._retry_now = threading.Event()  # set to connect again without waiting
        self._thread = Threads("frames-cluster")
        self._thread.submit(self._run)

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

    def confirm_scheduler(self) -> SchedulerIdentity | None:
        """Use from now on the scheduler that awaits consent; return it, or None."""
        self._confirmed, self.unconfirmed = self.unconfirmed, None
        self._retry_now.set()
        return self._confirmed

    def close(self) -> None:
        """Recall all frames and end the thread, without waiting for it."""
        self._closed.set()
        self._retry_now.set()
        self.request_frames(())
        self.request_urgent(request=None)
        self._thread.close()

    # Called by its thread

    @property
    def is_closed(self) -> bool:
        """True after `close` was called."""
        return self._closed.is_set()

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

    def set_status(self, workers: tuple[str, ...], problem: str, program: Program = ()) -> None:
        """Publish the workers that render, or the problem why none does, to the window."""
        status = workers, problem, program
        if status != (self.workers, self.problem, self.program):
            self.workers, self.problem, self.program = status
            self._wake()

    def _run(self) -> None:
        """Connect and serve the requests until `close` is called; runs on a thread."""
        while not self.is_closed:
            try:
                with connected(self.address, self._check_scheduler) as client:
                    _SchedulerConnection(self, client).run()
            except HeatlensError as error:
                self.set_status((), f"{error} {ON_THIS_MACHINE}")
            except NotDataError:
                self.set_status((), f"{not_data_error(self.address)} {ON_THIS_MACHINE}")
            except Exception as error:
                gone_message = f"The scheduler at {self.address} has gone."
                message = (
                    gone_message if is_loss(error) else to_heatlens_error(error, "Dask failed")
                )
                self.set_status((), f"{message} {ON_THIS_MACHINE}")
            self._retry_now.wait(_RETRY_S)
            self._retry_now.clear()

    def _check_scheduler(self, scheduler: SchedulerIdentity) -> None:
        """Raise InputError for a scheduler or a network that the user has not confirmed."""
        self.unconfirmed = None if scheduler == self._confirmed else scheduler
        if self.unconfirmed is None:
            return
        confirmed = self._confirmed
        if confirmed is None or confirmed.scheduler != scheduler.scheduler:
            reason = "is new to this window"
        elif confirmed.own_host != scheduler.own_host:
            reason = f"is reached from {scheduler.own_host}, and was from {confirmed.own_host}"
        else:
            reason = "is another than before, or was started again"
        raise InputError(
            f"The scheduler at {self.address} {reason}: if it is yours, choose Use this scheduler."
        )


@dataclass(frozen=True, eq=False)
class _SentFrame:
    """A frame that was sent to the scheduler; `workers` may render it."""

    request: FrameRequest
    future: Future
    workers: frozenset[str]


class _SchedulerConnection:
    """One connection to the scheduler, on the thread of a `FrameCluster`."""

    def __init__(self, cluster: FrameCluster, client: Client) -> None:
        self._cluster, self._client = cluster, client
        self._programs: dict[str, Future] = {}  # futures of the program of each worker
        self._known_programs: dict[str, Program] = {}  # the programs that workers have reported
        self._failures: dict[str, str] = {}  # the messages of workers that could not report theirs
        self._next_check_s = 0.0  # time of the next check of the workers
        self._sent_frames: dict[str, _SentFrame] = {}  # by the key of the frame
        self._own_program = own_program(*cluster.own_driver)

    def run(self) -> None:
        """Serve until the connection breaks or the window has closed."""
        while not self._cluster.is_closed and self._client.status == "running":
            if time.monotonic() >= self._next_check_s:
                self._check_workers()
            requests = self._cluster.open_requests()
            self._recall_frames({wish.key for wish in requests})
            self._send_frames(requests)
            self._pass_on_results(self._cluster.wait_for_signals(_WORKER_CHECK_S))
        if not self._cluster.is_closed:
            raise ConnectionError

    def _pass_on_results(self, signals: Sequence[Future | None]) -> None:
        """Deliver the results of the frames whose futures are finished."""
        finished_futures = {id(future) for future in signals if future is not None}
        finished = [it for it in self._sent_frames.values() if id(it.future) in finished_futures]
        for it in finished:
            del self._sent_frames[it.request.key]
        self._cluster.deliver_results([answer for it in finished for answer in _result_of(it)])

    def _recall_frames(self, requested_keys: set[str]) -> None:
        """Cancel sent frames that are no longer requested, or whose workers have all gone."""
        current_workers = set(self._cluster.workers)
        recalled = [
            key
            for key, it in self._sent_frames.items()
            if key not in requested_keys or not it.workers & current_workers
        ]
        if recalled:
            self._client.cancel([self._sent_frames.pop(key).future for key in recalled])

    def _send_frames(self, requests: Sequence[FrameRequest]) -> None:
        """Send as many of the requested frames as the workers can queue; one more if urgent."""
        workers = self._cluster.workers
        capacity = (
            _FRAMES_PER_WORKER * len(workers)
            - len(self._sent_frames)
            - self._cluster.uncollected_count
        )
        unsent = [request for request in requests if request.key not in self._sent_frames]
        is_urgent = bool(unsent) and not unsent[0].is_kept
        for request in unsent[: max(0, capacity, is_urgent)]:
            self._send_frame(request, workers)

    def _send_frame(self, request: FrameRequest, workers: Sequence[str]) -> None:
        """Send one frame to `workers`; a failure becomes its result."""
        try:
            job = job_to_send(request.make())
        except HeatlensError as error:
            self._cluster.deliver_results(
                [FrameResult(request.key, picture=None, problem=str(error))]
            )
            return
        task = {
            "pure": False,
            "workers": list(workers),
            "priority": 0 if request.is_kept else _URGENT_PRIORITY,
        }
        future = self._client.submit(
            answer_frame, job, self._cluster.own_driver[2], request.is_kept, **task
        )
        self._sent_frames[request.key] = _SentFrame(request, future, frozenset(workers))
        future.add_done_callback(self._cluster.signal)

    def _check_workers(self) -> None:
        """Ask new workers for their programs, and choose the workers that render.

        They are those with the program of this machine; if there are none, those with the program
        of the first worker.
        """
        self._next_check_s = time.monotonic() + _WORKER_CHECK_S
        current_workers = self._client.scheduler_info(n_workers=-1)["workers"]
        self._programs = {
            it: future for it, future in self._programs.items() if it in current_workers
        }
        for worker in [it for it in current_workers if it not in self._programs]:
            task = {"pure": False, "workers": [worker], "priority": _URGENT_PRIORITY}
            self._programs[worker] = self._client.submit(
                answer_program, self._cluster.own_driver[2], **task
            )
            self._programs[worker].add_done_callback(self._check_workers_soon)
        self._choose_workers()

    def _check_workers_soon(self, _future: Future) -> None:
        """Have the workers checked in the next step, after one of them has answered."""
        self._next_check_s = 0.0
        self._cluster.signal(None)

    def _learn_programs(self) -> None:
        """Forget the programs of workers that are gone, and read those that have arrived."""
        self._known_programs = {
            it: program for it, program in self._known_programs.items() if it in self._programs
        }
        self._failures = {it: why for it, why in self._failures.items() if it in self._programs}
        for it, future in self._programs.items():
            is_new = it not in self._known_programs and it not in self._failures
            if is_new and future.status in ("finished", "error"):
                self._learn_program(it, future)

    def _learn_program(self, worker: str, future: Future) -> None:
        """Store the program of a worker, or the message of its failure."""
        try:
            answer = answer_of(future)
            if answer is not None:
                self._known_programs[worker] = program_of_answer(answer)
        except HeatlensError as error:
            self._failures[worker] = str(error)

    # Two graphics drivers draw the same frame with different last digits, and a shot should not mix
    # them. So all workers that render have one program, if possible that of this machine, because
    # the window renders frames too.
    def _choose_workers(self) -> None:
        """Choose the workers that render, all with the same program, and publish them."""
        self._learn_programs()
        compatible = {
            it: worker_program
            for it, worker_program in self._known_programs.items()
            if worker_program[:2] == self._own_program[:2]
        }
        program = (
            self._own_program
            if self._own_program in compatible.values()
            else next(iter(compatible.values()), ())
        )
        workers = tuple(
            it for it, worker_program in compatible.items() if worker_program == program
        )
        is_waiting = any(future.status == "pending" for future in self._programs.values())
        problem = "" if workers or is_waiting else f"{self._no_worker_message} {ON_THIS_MACHINE}"
        self._cluster.set_status(workers, problem, () if program == self._own_program else program)

    @property
    def _no_worker_message(self) -> str:
        """The message why no worker renders."""
        if not self._programs:
            return f"No worker is at {self._cluster.address}."
        return next(
            iter(self._failures.values()),
            f"The workers at {self._cluster.address} have another heatlens.",
        )


def _result_of(sent: _SentFrame) -> Iterator[FrameResult]:
    """Yield the result of a sent frame; nothing if it was recalled or its worker has died."""
    key = sent.request.key
    try:
        answer = answer_of(sent.future)
        picture = None if answer is None else picture_of_answer(answer)
    except HeatlensError as error:
        yield FrameResult(key, picture=None, problem=str(error))
    else:
        if picture is not None:
            yield FrameResult(key, picture)
