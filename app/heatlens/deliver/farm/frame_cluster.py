"""Have frames rendered for the window by the workers of a Dask cluster.

A thread speaks with the scheduler, so that no method waits for the network.
"""

import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from heatlens.core.base.background import Threads
from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.base.faults import to_heatlens_error
from heatlens.deliver.farm.answers import answer_of
from heatlens.deliver.farm.connection import SchedulerIdentity, connected, is_loss, not_data_error
from heatlens.deliver.farm.dask_types import Client, Future
from heatlens.deliver.farm.data_only import NotDataError
from heatlens.deliver.farm.frame_queue import FrameQueue, FrameRequest, FrameResult
from heatlens.deliver.farm.frame_worker import answer_frame, job_to_send, picture_of_answer
from heatlens.deliver.farm.render_workers import ON_THIS_MACHINE, RenderWorkers, WorkersStatus
from heatlens.render.defocus.line_solver import SolverName

_LONGEST_WAIT_S = 1.0  # for a finished frame or a new request, before the workers are checked
_RETRY_S = 10.0  # after a failure, time until the scheduler is tried again
_FRAMES_PER_WORKER = 2  # frames that each worker has, so that none waits for the next
_URGENT_PRIORITY = 10  # priority of a picture that somebody waits for


# Every call of Dask's client may wait for the network, or for a scheduler that has gone, and a
# window may not wait. So one thread alone has the client; the window writes requests and reads
# results in a queue.
class FrameCluster:
    """The connection of one window to one scheduler; `frames` holds its requests and results."""

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
        self.frames = FrameQueue(wake)
        self.status = WorkersStatus()
        self.unconfirmed: SchedulerIdentity | None = (
            None  # the scheduler that answers, until the user confirms it
        )
        self._confirmed = confirmed
        self._wake = wake
        self._closed = threading.Event()
        self._retry_now = threading.Event()  # set to connect again without waiting
        self._thread = Threads("frames-cluster")
        self._thread.submit(self._run)

    # Called by the window

    def confirm_scheduler(self) -> SchedulerIdentity | None:
        """Use from now on the scheduler that awaits consent; return it, or None."""
        self._confirmed, self.unconfirmed = self.unconfirmed, None
        self._retry_now.set()
        return self._confirmed

    def close(self) -> None:
        """Recall all frames and end the thread, without waiting for it."""
        self._closed.set()
        self._retry_now.set()
        self.frames.request_frames(())
        self.frames.request_urgent(request=None)
        self._thread.close()

    # Called by its thread

    @property
    def is_closed(self) -> bool:
        """True after `close` was called."""
        return self._closed.is_set()

    def set_status(self, status: WorkersStatus) -> None:
        """Publish a new status to the window."""
        if status != self.status:
            self.status = status
            self._wake()

    def _run(self) -> None:
        """Connect and serve the requests until `close` is called; runs on a thread."""
        while not self.is_closed:
            try:
                with connected(self.address, self._check_scheduler) as client:
                    _SchedulerConnection(self, client).run()
            except HeatlensError as error:
                self.set_status(WorkersStatus(problem=f"{error} {ON_THIS_MACHINE}"))
            except NotDataError:
                self.set_status(
                    WorkersStatus(problem=f"{not_data_error(self.address)} {ON_THIS_MACHINE}")
                )
            except Exception as error:
                gone_message = f"The scheduler at {self.address} has gone."
                message = (
                    gone_message if is_loss(error) else to_heatlens_error(error, "Dask failed")
                )
                self.set_status(WorkersStatus(problem=f"{message} {ON_THIS_MACHINE}"))
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
        self._cluster, self._client, self._frames = cluster, client, cluster.frames
        self._workers = RenderWorkers(
            cluster.address, client, cluster.own_driver, lambda: self._frames.signal(None)
        )
        self._sent_frames: dict[str, _SentFrame] = {}  # by the key of the frame

    def run(self) -> None:
        """Serve until the connection breaks or the window has closed."""
        while not self._cluster.is_closed and self._client.status == "running":
            if self._workers.should_check:
                self._cluster.set_status(self._workers.check())
            requests = self._frames.open_requests()
            self._recall_frames({wish.key for wish in requests})
            self._send_frames(requests)
            self._pass_on_results(self._frames.wait_for_signals(_LONGEST_WAIT_S))
        if not self._cluster.is_closed:
            raise ConnectionError

    def _pass_on_results(self, signals: Sequence[Future | None]) -> None:
        """Deliver the results of the frames whose futures are finished."""
        finished_futures = {id(future) for future in signals if future is not None}
        finished = [it for it in self._sent_frames.values() if id(it.future) in finished_futures]
        for it in finished:
            del self._sent_frames[it.request.key]
        self._frames.deliver_results([answer for it in finished for answer in _result_of(it)])

    def _recall_frames(self, requested_keys: set[str]) -> None:
        """Cancel sent frames that are no longer requested, or whose workers have all gone."""
        current_workers = set(self._cluster.status.workers)
        recalled = [
            key
            for key, it in self._sent_frames.items()
            if key not in requested_keys or not it.workers & current_workers
        ]
        if recalled:
            self._client.cancel([self._sent_frames.pop(key).future for key in recalled])

    def _send_frames(self, requests: Sequence[FrameRequest]) -> None:
        """Send as many of the requested frames as the workers can queue; one more if urgent."""
        workers = self._cluster.status.workers
        capacity = (
            _FRAMES_PER_WORKER * len(workers)
            - len(self._sent_frames)
            - self._frames.uncollected_count
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
            self._frames.deliver_results(
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
        future.add_done_callback(self._frames.signal)


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
