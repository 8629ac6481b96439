"""Hand the frames of an export to the workers of a Dask cluster, and follow them.

Dask's scheduler gives tasks to workers, and again to others if a worker is lost. Workers send an
event for each finished frame; progress is therefore shown before a task of several frames is done.
"""

import queue
import signal
import uuid
from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace

from heatlens.core.base.errors import InputError
from heatlens.core.base.outside_text import printable
from heatlens.core.base.stopping import Stopped, StopSignals, temporary_folder
from heatlens.deliver.export.finished import is_finished
from heatlens.deliver.export.plan import ExportPlan, PlannedFrame
from heatlens.deliver.export.run import FrameDone
from heatlens.deliver.export.sequence_check import Remark
from heatlens.deliver.farm.answers import (
    FetchedPart,
    PartDone,
    answer_of,
    frames_of_answer,
    parse_event_text,
)
from heatlens.deliver.farm.connection import is_loss, not_data_error
from heatlens.deliver.farm.dask_types import Client, Future
from heatlens.deliver.farm.data_only import NotDataError
from heatlens.media.files.atomic_file import write_atomically
from heatlens.media.files.json_record import digest
from heatlens.media.sequence.names import frames_text, parse_frames

# The signal that ends this process and leaves the export to the cluster; Windows has none.
DETACH_SIGNAL: signal.Signals | None = getattr(signal, "SIGHUP", None)
_WORKER_CHECK_S = 2.0  # interval between checks for lost workers
_TASKS_PER_WORKER, _MOST_FRAMES_PER_TASK = (
    4,
    8,
)  # tasks are short, so that all workers end at one time


@dataclass(frozen=True)
class PartTask:
    """The description of a task that is sent to a worker.

    words    command line of `heatlens`, with the paths of this machine
    frames   the frames to make, as `parse_frames` takes them
    version  version of heatlens, which the worker must have too
    fetch    True if the files come back over the network; else the worker writes them
    topic    topic of the events for finished frames
    """

    words: tuple[str, ...]
    frames: str
    version: str
    fetch: bool
    topic: str


Work = Callable[[PartTask], bytes]  # returns an answer, see `deliver/farm/answers.py`
Event = dict[str, object]  # the event for a finished frame


class ClusterMaker:
    """Makes frames on a cluster; `report` shows messages to the user."""

    def __init__(
        self,
        client: Client,
        work: Work,
        task: PartTask,
        chunk: int | None,
        report: Callable[[str], None],
        strict: bool = False,
    ) -> None:
        """Create it; `task` describes all frames, which are sent in parts of `chunk` frames.

        If `strict`, workers with different graphics drivers are an error.
        """
        self._drivers: dict[str, str] = {}  # the first worker of each driver
        self._strict = strict
        self._patience = 1.0  # limits of `answer_of`; large files take long over a slow network
        self._is_detached = (
            False  # True: the tasks go on, and the same export can follow them later
        )
        self._client = client
        self._work = work
        self._task = task
        self._chunk = chunk
        self._report = report
        self._events: queue.SimpleQueue[Future | Event | None] = queue.SimpleQueue()

    def __call__(self, frames: Sequence[PlannedFrame]) -> Iterator[FrameDone]:
        """Yield the frames as they are finished. Raises InputError where one fails."""
        with _scheduler_errors_as_input_errors(self._client):
            yield from self._make_frames(frames)

    def _make_frames(self, frames: Sequence[PlannedFrame]) -> Iterator[FrameDone]:
        """Send the tasks that no earlier client has sent, and yield the frames of all tasks."""
        self._wait_for_workers()
        waiting = {frame.frame: frame for frame in frames}
        self._client.subscribe_topic(self._task.topic, lambda event: self._events.put(event[1]))
        earlier_tasks = self._take_over_tasks(waiting)
        pending = earlier_tasks | self._send_tasks(
            sorted(waiting.keys() - _frames_of(earlier_tasks))
        )
        with self._keep_or_cancel_tasks(pending) as stops:
            while pending:
                arrival = self._next_event(stops)
                parts: list[FetchedPart] | None
                if isinstance(arrival, dict):
                    parts = [(parse_event_text(arrival.get("frame")), None)]
                else:
                    pending.remove(arrival)
                    if (
                        arrival in earlier_tasks and arrival.status == "error"
                    ):  # perhaps it is mended now
                        pending |= self._send_tasks(sorted(waiting.keys() & _frames_of([arrival])))
                        continue
                    parts = _frames_of_task(arrival, self._patience)
                    if parts is None:
                        pending.add(self._wait_again(arrival))
                for done, data in parts or ():
                    self._compare_driver(done)
                    if done.frame in waiting:
                        yield self._store_frame(done, data, waiting.pop(done.frame))

    # A worker can die after its task is done and before the answer is fetched. The scheduler then
    # waits for a worker that never comes back. Therefore each fetch has a time limit, which doubles
    # because large files take long over a slow network. Without a limit, frames ahead stopped in 2
    # of 18 runs under load.
    def _wait_again(self, future: Future) -> Future:
        """Wait again for a task without an answer: it is made anew, or its answer takes longer."""
        if future.status == "finished":
            self._patience *= 2
        self._wait_for_workers()
        future.add_done_callback(self._events.put)
        return future

    def _take_over_tasks(self, frames: Container[int]) -> set[Future]:
        """Return the tasks of an earlier client of this export that make frames still needed."""
        published = self._client.get_dataset(self._task.topic, default=())
        taken_over = {it for it in published if any(frame in frames for frame in _frames_of([it]))}
        if taken_over:
            self._report("goes on with what the cluster has under way.")
        for future in taken_over:
            future.add_done_callback(self._events.put)
        return taken_over

    @contextmanager
    def _keep_or_cancel_tasks(self, pending: set[Future]) -> Iterator[StopSignals]:
        """Let the tasks go on at the scheduler if this process is killed or its terminal closes.

        Whoever starts the same export again follows them. Ctrl-C and failures cancel them.
        """
        if not self._task.fetch:  # else nobody could take their files
            self._client.publish_dataset([*pending], name=self._task.topic, override=True)
        with StopSignals(lambda: self._events.put(None)) as stops:
            try:
                yield stops
            except Stopped as stop:
                self._is_detached = stop.number == DETACH_SIGNAL
                raise
            finally:
                if not self._is_detached and self._client.status == "running":
                    self._client.cancel([*pending], force=True)

    def unpublish(self) -> None:
        """Remove this export from the scheduler, unless it is left there."""
        if not self._is_detached and self._client.status == "running":
            with suppress(OSError, TimeoutError):  # the scheduler has gone
                self._client.unpublish_dataset(self._task.topic)

    def _store_frame(self, done: PartDone, data: bytes | None, frame: PlannedFrame) -> FrameDone:
        """Write the file of a frame if it was fetched; return what is reported of the frame.

        Raises InputError if the file is that of another frame.
        """
        if self._task.fetch:
            _write_fetched(data or b"", frame)
        remarks = tuple(Remark(*remark) for remark in done.remarks)
        maker = done.driver[1] if done.driver else ""
        surfaces_lost = done.surfaces_lost
        return FrameDone(
            done.frame, frame.path, done.was_there, surfaces_lost, remarks, maker, done.pace
        )

    def _compare_driver(self, done: PartDone) -> None:
        """Report a graphics driver that no worker had before. Raises InputError if strict."""
        driver, worker = map(printable, done.driver or ("", ""))
        if not driver or driver in self._drivers:
            return
        self._drivers[driver] = worker
        if len(self._drivers) == 1:
            return
        names = ", ".join(f"{name} ({address})" for name, address in self._drivers.items())
        message = f"workers have different graphics drivers: {names}"
        if self._strict:
            raise InputError(f"{message[0].upper()}{message[1:]}. Finished frames are kept.")
        self._report(f"{message}; their pictures may differ slightly.")

    def _send_tasks(self, frames: Sequence[int]) -> set[Future]:
        """Send tasks for `frames`; return their futures, which enter the queue when done."""
        workers = max(1, len(self._client.nthreads()))  # the last one may have left just now
        frames_per_task = -(-len(frames) // (_TASKS_PER_WORKER * workers))
        chunk = self._chunk or min(_MOST_FRAMES_PER_TASK, max(1, frames_per_task))
        texts = [
            frames_text(frames[begin : begin + chunk]) for begin in range(0, len(frames), chunk)
        ]
        futures = {
            self._client.submit(self._work, replace(self._task, frames=text), pure=False, key=key)
            for text in texts
            for key in [f"{self._task.topic}:{uuid.uuid4().hex}:{text}"]
        }
        for future in futures:
            future.add_done_callback(self._events.put)
        return futures

    def _wait_for_workers(self) -> None:
        """Wait until there is a worker, after a message to the user if there is none."""
        if not self._client.nthreads():
            address = self._client.scheduler.address
            self._report(f"no worker is there yet; start one with: heatlens worker {address}")
            self._client.wait_for_workers(1)

    def _next_event(self, stops: StopSignals) -> Future | Event:
        """Return the next event or finished future; report it if the last worker is lost."""
        while True:
            stops.raise_if_stopped()
            try:
                event = self._events.get(timeout=_WORKER_CHECK_S)
            except queue.Empty:
                if self._client.status == "running":
                    self._wait_for_workers()
            else:
                if event is not None:
                    return event


def _frames_of(futures: Iterable[Future]) -> set[int]:
    """Return the frames that these tasks make, which are named in their keys."""
    return {frame for it in futures for frame in parse_frames(_frames_text(it))}


def _frames_text(future: Future) -> str:
    return str(future.key).rpartition(":")[2]


def _frames_of_task(future: Future, patience: float) -> list[FetchedPart] | None:
    """Return the frames of a task, or None as `answer_of` does.

    Raises InputError with the reason if the task has failed; finished frames are kept.
    """
    try:
        answer = answer_of(future, patience)
        return None if answer is None else frames_of_answer(answer)
    except InputError as error:
        if future.status != "error":
            raise
        message = f"frames {_frames_text(future)}: {error} Finished frames are kept."
        raise InputError(message) from error


@contextmanager
def _scheduler_errors_as_input_errors(client: Client) -> Iterator[None]:
    """Turn the errors of Dask after the loss of its scheduler into an InputError."""
    try:
        yield
    except NotDataError as error:
        raise not_data_error(client.scheduler.address) from error
    except Exception as error:
        if not is_loss(error):
            raise
        raise InputError(
            "The scheduler has gone. Finished frames are kept; start it and export again."
        ) from error


def _write_fetched(data: bytes, frame: PlannedFrame) -> None:
    """Write a file that a worker has sent. Raises InputError unless it is the frame's."""
    with temporary_folder() as folder:
        fetched = replace(frame, path=folder / frame.path.name)
        fetched.path.write_bytes(data)
        if not is_finished(fetched):
            raise InputError(
                f"frame {frame.frame}: a worker has sent a damaged file, or that of another "
                "frame. Finished frames are kept; export again to go on."
            )
    write_atomically(frame.path, data)


def topic_of(plan: ExportPlan, fetch: bool) -> str:
    """Return the topic of an export, which is the same if it is started again."""
    frames = [[str(frame.path), frame.fingerprint] for frame in plan.frames]
    return f"heatlens-{digest({'frames': frames, 'fetch': fetch})}"
