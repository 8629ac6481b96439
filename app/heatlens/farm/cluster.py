"""Hand the frames of an export to the workers of a Dask cluster, and follow them.

Dask's scheduler gives tasks to workers, and again to others if a worker is lost. Workers tell of
each frame by an event, so that progress is shown before a task of several frames is done.
"""

import logging
import queue
import re
import signal
import uuid
from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from heatlens.base.errors import HeatlensError, InputError
from heatlens.base.extras import import_extra
from heatlens.base.stopping import Stopped, StopSignals
from heatlens.export.plan import ExportPlan, PlannedFrame
from heatlens.export.run import FrameDone
from heatlens.export.sequence_check import Remark
from heatlens.farm.dask_types import Client, Future
from heatlens.files.atomic_file import write_whole
from heatlens.files.json_record import digest
from heatlens.sequence.names import frames_text, parse_frames

PATIENCE_S = 10  # time limit for an answer of the scheduler
_ADDRESS = re.compile(r"(tcp|tls|wss?)://(\[[\da-f:.]+\]|[^\s/:]+):\d{1,5}")
# The signal that leaves an export to the cluster; Windows has none.
LEAVE: signal.Signals | None = getattr(signal, "SIGHUP", None)
NO_ANSWER = (OSError, ValueError, TimeoutError)  # raised if there is no answer
_LOSSES = ("FutureCancelledError", "CancelledError", "CommClosedError")  # the scheduler has died
_LOOK_S = 2.0  # interval between checks for lost workers
_TASKS_OF_A_WORKER, _FRAMES_MOST = 4, 8  # tasks are short, so that all workers end at one time


def library() -> Any:
    """Import Dask. Raises InputError that says what to install."""
    found = import_extra("distributed", "A cluster", "cluster")
    for name in ("distributed", "distributed.client"):  # they would log every lost connection
        logging.getLogger(name).setLevel(logging.CRITICAL)
    return found


@dataclass(frozen=True)
class PartTask:
    """What a worker is sent.

    words    of `heatlens`, with the paths of this machine
    frames   those to make, as `parse_frames` takes them
    version  of heatlens, which must be that of the worker
    fetch    the files come back over the network, and are not written where the words say
    topic    of the events that tell of finished frames
    """

    words: tuple[str, ...]
    frames: str
    version: str
    fetch: bool
    topic: str


@dataclass(frozen=True)
class PartDone:
    """A frame that a worker has made, see `FrameDone`.

    data    its file if it is fetched
    driver  OpenGL driver and address of the worker; None for a frame that was there
    """

    frame: int
    was_there: bool
    surfaces_lost: str
    remarks: Sequence[Sequence[str]]
    data: bytes | None = None
    driver: tuple[str, str] | None = None
    pace: str = ""


Work = Callable[[PartTask], list[PartDone]]
Event = dict[str, Any]  # of a finished frame


@contextmanager
def connected(address: str) -> Iterator[Client]:
    """Yield a client of the scheduler at `address`. Raises InputError if it does not answer."""
    checked_address(address)
    try:
        client = library().Client(address, timeout=PATIENCE_S, set_as_default=False)
    except NO_ANSWER as error:
        raise no_answer(address) from error
    try:
        yield client
    finally:
        client.close(timeout=PATIENCE_S)


def checked_address(text: str) -> str:
    """Return the address in a text. Raises InputError if it is none."""
    address = text.strip()
    if not _ADDRESS.fullmatch(address):
        raise no_answer(repr(address))
    return address


def no_answer(address: str) -> InputError:
    """Return the error for a scheduler that does not answer."""
    return InputError(
        f"No Dask scheduler answers at {address}. Start one with `dask scheduler`, and name its "
        "address, such as tcp://192.168.1.20:8786."
    )


class ClusterMaker:
    """Makes frames on a cluster; `say` tells the user that it waits for workers."""

    def __init__(
        self,
        client: Client,
        work: Work,
        task: PartTask,
        chunk: int | None,
        say: Callable[[str], None],
        strict: bool = False,
    ) -> None:
        """Create it; `task` describes all frames, which are sent in parts of `chunk` frames.

        If `strict`, workers with different OpenGL drivers are an error.
        """
        self._drivers: dict[str, str] = {}  # the first worker of each driver
        self._strict = strict
        self._patience = 1.0  # limits of `answer_of`; large files take long over a slow network
        self._is_left = False  # whoever starts the same export again follows it
        self._client = client
        self._work = work
        self._task = task
        self._chunk = chunk
        self._say = say
        self._news: queue.SimpleQueue[Future | Event | None] = queue.SimpleQueue()

    def __call__(self, frames: Sequence[PlannedFrame]) -> Iterator[FrameDone]:
        """Yield the frames as they are finished. Raises InputError where one fails."""
        with _loss_told():
            yield from self._made(frames)

    def _made(self, frames: Sequence[PlannedFrame]) -> Iterator[FrameDone]:
        self._wait_for_workers()
        waiting = {frame.frame: frame.path for frame in frames}
        self._client.subscribe_topic(self._task.topic, lambda event: self._news.put(event[1]))
        old = self._taken_over(waiting)
        pending = old | self._sent(sorted(waiting.keys() - _frames_of(old)))
        with self._kept(pending) as stops:
            while pending:
                news = self._next(stops)
                found: list[PartDone] | None
                if isinstance(news, dict):
                    found = [PartDone(**{name: news[name] for name in news.keys() - {"worker"}})]
                else:
                    pending.remove(news)
                    if news in old and news.status == "error":  # perhaps it is mended now
                        pending |= self._sent(sorted(waiting.keys() & _frames_of([news])))
                        continue
                    found = _result(news, self._patience)
                    if found is None:
                        pending.add(self._awaited_again(news))
                for done in found or ():
                    self._compare(done)
                    if done.frame in waiting:
                        yield _stored(done, waiting.pop(done.frame))

    def _awaited_again(self, future: Future) -> Future:
        """Have a task announce itself again: it is made anew, or its answer takes longer."""
        if future.status == "finished":
            self._patience *= 2
        self._wait_for_workers()
        future.add_done_callback(self._news.put)
        return future

    def _taken_over(self, frames: Container[int]) -> set[Future]:
        """Return the futures of an earlier client of this export that are still of use."""
        there = self._client.get_dataset(self._task.topic, default=())
        found = {it for it in there if any(frame in frames for frame in _frames_of([it]))}
        if found:
            self._say("goes on with what the cluster has under way.")
        for future in found:
            future.add_done_callback(self._news.put)
        return found

    @contextmanager
    def _kept(self, pending: set[Future]) -> Iterator[StopSignals]:
        """Let the tasks go on at the scheduler if this process is killed or its terminal closes.

        Whoever starts the same export again follows them. Ctrl-C and failures cancel them.
        """
        if not self._task.fetch:  # else nobody could take their files
            self._client.publish_dataset([*pending], name=self._task.topic, override=True)
        with StopSignals(lambda: self._news.put(None)) as stops:
            try:
                yield stops
            except Stopped as stop:
                self._is_left = stop.number == LEAVE
                raise
            finally:
                if not self._is_left and self._client.status == "running":
                    self._client.cancel([*pending], force=True)

    def forget(self) -> None:
        """Remove this export from the scheduler, unless it is left there."""
        if not self._is_left and self._client.status == "running":
            with suppress(OSError, TimeoutError):  # the scheduler has gone
                self._client.unpublish_dataset(self._task.topic)

    def _compare(self, done: PartDone) -> None:
        """Tell of a driver that no worker had before. Raises InputError if that is refused."""
        driver, worker = done.driver or ("", "")
        if not driver or driver in self._drivers:
            return
        self._drivers[driver] = worker
        if len(self._drivers) == 1:
            return
        named = ", ".join(f"{name} ({where})" for name, where in self._drivers.items())
        told = f"workers have different OpenGL drivers: {named}"
        if self._strict:
            raise InputError(f"{told[0].upper()}{told[1:]}. Finished frames are kept.")
        self._say(f"{told}; their pictures may differ slightly.")

    def _sent(self, frames: Sequence[int]) -> set[Future]:
        """Send the tasks; return their futures, which announce themselves when they are done."""
        share = -(-len(frames) // (_TASKS_OF_A_WORKER * len(self._client.nthreads())))
        size = self._chunk or min(_FRAMES_MOST, max(1, share))
        texts = [frames_text(frames[at : at + size]) for at in range(0, len(frames), size)]
        futures = {
            self._client.submit(self._work, replace(self._task, frames=text), pure=False, key=key)
            for text in texts
            for key in [f"{self._task.topic}:{uuid.uuid4().hex}:{text}"]
        }
        for future in futures:
            future.add_done_callback(self._news.put)
        return futures

    def _wait_for_workers(self) -> None:
        if not self._client.nthreads():
            address = self._client.scheduler.address
            self._say(f"no worker is there yet; start one with: heatlens worker {address}")
            self._client.wait_for_workers(1)

    def _next(self, stops: StopSignals) -> Future | Event:
        """Return the next event or finished future; say so if the last worker is lost."""
        while True:
            stops.raise_if_stopped()
            try:
                news = self._news.get(timeout=_LOOK_S)
            except queue.Empty:
                if self._client.status == "running":
                    self._wait_for_workers()
            else:
                if news is not None:
                    return news


def _frames_of(futures: Iterable[Future]) -> set[int]:
    """Return the frames that these tasks make, which are named in their keys."""
    return {frame for it in futures for frame in parse_frames(_frames_text(it))}


def _frames_text(future: Future) -> str:
    return str(future.key).rpartition(":")[2]


def answer_of(future: Future, patience: float = 1.0) -> Any:
    """Return what a task has found, or None if its worker has died with it, as far as is known.

    The scheduler would wait for ever for a worker. `patience` is in usual limits of time.
    """
    with suppress(TimeoutError):
        return future.result(timeout=patience * PATIENCE_S)
    return None


def _result(future: Future, patience: float) -> list[PartDone] | None:
    """Return `answer_of` a task. Raises InputError with a sentence for an error of Dask."""
    name = f"frames {_frames_text(future)}"
    try:
        found: list[PartDone] | None = answer_of(future, patience)
    except HeatlensError:
        raise
    except library().scheduler.KilledWorker as error:
        raise InputError(
            f"{name}: the workers that made them died, {error.last_worker.address} the last; "
            "their memory may be too small. Finished frames are kept."
        ) from error
    return found


@contextmanager
def _loss_told() -> Iterator[None]:
    """Turn the errors of Dask after the loss of its scheduler into an InputError."""
    try:
        yield
    except Exception as error:
        if not is_loss(error):
            raise
        raise InputError(
            "The scheduler has gone. Finished frames are kept; start it and export again."
        ) from error


def is_loss(error: Exception) -> bool:
    """Return True for the errors of Dask after the loss of its scheduler."""
    return isinstance(error, NO_ANSWER) or type(error).__name__ in _LOSSES


def _stored(done: PartDone, path: Path) -> FrameDone:
    if done.data is not None:
        write_whole(path, done.data)
    remarks = tuple(Remark(*told) for told in done.remarks)
    maker = done.driver[1] if done.driver else ""
    lost = done.surfaces_lost
    return FrameDone(done.frame, path, done.was_there, lost, remarks, maker, done.pace)


def topic_of(plan: ExportPlan, fetch: bool) -> str:
    """Return the topic of an export, which is the same if it is started again."""
    frames = [[str(frame.path), frame.fingerprint] for frame in plan.frames]
    return f"heatlens-{digest({'frames': frames, 'fetch': fetch})}"
