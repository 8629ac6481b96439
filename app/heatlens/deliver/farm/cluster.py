"""Hand the frames of an export to the workers of a Dask cluster, and follow them.

Dask's scheduler gives tasks to workers, and again to others if a worker is lost. Workers tell of
each frame by an event, so that progress is shown before a task of several frames is done.
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
    part_of_text,
    parts_of_answer,
)
from heatlens.deliver.farm.connection import is_loss, not_data
from heatlens.deliver.farm.dask_types import Client, Future
from heatlens.deliver.farm.data_only import NotDataError
from heatlens.media.files.atomic_file import write_whole
from heatlens.media.files.json_record import digest
from heatlens.media.sequence.names import frames_text, parse_frames

# The signal that leaves an export to the cluster; Windows has none.
LEAVE: signal.Signals | None = getattr(signal, "SIGHUP", None)
_LOOK_S = 2.0  # interval between checks for lost workers
_TASKS_OF_A_WORKER, _FRAMES_MOST = 4, 8  # tasks are short, so that all workers end at one time


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


Work = Callable[[PartTask], bytes]  # which makes an answer, see `deliver/farm/answers.py`
Event = dict[str, object]  # of a finished frame


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
        with _loss_told(self._client):
            yield from self._made(frames)

    def _made(self, frames: Sequence[PlannedFrame]) -> Iterator[FrameDone]:
        self._wait_for_workers()
        waiting = {frame.frame: frame for frame in frames}
        self._client.subscribe_topic(self._task.topic, lambda event: self._news.put(event[1]))
        old = self._taken_over(waiting)
        pending = old | self._sent(sorted(waiting.keys() - _frames_of(old)))
        with self._kept(pending) as stops:
            while pending:
                news = self._next(stops)
                parts: list[FetchedPart] | None
                if isinstance(news, dict):
                    parts = [(part_of_text(news.get("frame")), None)]
                else:
                    pending.remove(news)
                    if news in old and news.status == "error":  # perhaps it is mended now
                        pending |= self._sent(sorted(waiting.keys() & _frames_of([news])))
                        continue
                    parts = _result(news, self._patience)
                    if parts is None:
                        pending.add(self._awaited_again(news))
                for done, data in parts or ():
                    self._compare(done)
                    if done.frame in waiting:
                        yield self._stored(done, data, waiting.pop(done.frame))

    # A worker can die after its task is done and before the answer is fetched. The scheduler then
    # waits for a worker that never comes back, and a client that asks without a limit stands still:
    # frames ahead stopped in 2 of 18 runs under load. Each question has a limit, which doubles,
    # because large files take long over a slow network.
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
        taken = {it for it in there if any(frame in frames for frame in _frames_of([it]))}
        if taken:
            self._say("goes on with what the cluster has under way.")
        for future in taken:
            future.add_done_callback(self._news.put)
        return taken

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

    def _stored(self, done: PartDone, data: bytes | None, frame: PlannedFrame) -> FrameDone:
        """Write the file of a frame if it was fetched. Raises InputError for another frame's."""
        if self._task.fetch:
            _write_fetched(data or b"", frame)
        remarks = tuple(Remark(*remark) for remark in done.remarks)
        maker = done.driver[1] if done.driver else ""
        lost = done.surfaces_lost
        return FrameDone(done.frame, frame.path, done.was_there, lost, remarks, maker, done.pace)

    def _compare(self, done: PartDone) -> None:
        """Tell of a driver that no worker had before. Raises InputError if that is refused."""
        driver, worker = map(printable, done.driver or ("", ""))
        if not driver or driver in self._drivers:
            return
        self._drivers[driver] = worker
        if len(self._drivers) == 1:
            return
        named = ", ".join(f"{name} ({where})" for name, where in self._drivers.items())
        sentence = f"workers have different OpenGL drivers: {named}"
        if self._strict:
            raise InputError(f"{sentence[0].upper()}{sentence[1:]}. Finished frames are kept.")
        self._say(f"{sentence}; their pictures may differ slightly.")

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


def _result(future: Future, patience: float) -> list[FetchedPart] | None:
    """Return the frames of a task, or None as `answer_of` does. Raises InputError with a sentence.

    Whatever has failed, finished frames are kept.
    """
    try:
        answer = answer_of(future, patience)
        return None if answer is None else parts_of_answer(answer)
    except InputError as error:
        if future.status != "error":
            raise
        sentence = f"frames {_frames_text(future)}: {error} Finished frames are kept."
        raise InputError(sentence) from error


@contextmanager
def _loss_told(client: Client) -> Iterator[None]:
    """Turn the errors of Dask after the loss of its scheduler into an InputError."""
    try:
        yield
    except NotDataError as error:
        raise not_data(client.scheduler.address) from error
    except Exception as error:
        if not is_loss(error):
            raise
        raise InputError(
            "The scheduler has gone. Finished frames are kept; start it and export again."
        ) from error


def _write_fetched(data: bytes, frame: PlannedFrame) -> None:
    """Write a file that a worker has sent, once it is seen that it is that of the frame."""
    with temporary_folder() as folder:
        seen = replace(frame, path=folder / frame.path.name)
        seen.path.write_bytes(data)
        if not is_finished(seen):
            raise InputError(
                f"frame {frame.frame}: what a worker has sent is not the finished file of this "
                "frame. Finished frames are kept."
            )
    write_whole(frame.path, data)


def topic_of(plan: ExportPlan, fetch: bool) -> str:
    """Return the topic of an export, which is the same if it is started again."""
    frames = [[str(frame.path), frame.fingerprint] for frame in plan.frames]
    return f"heatlens-{digest({'frames': frames, 'fetch': fetch})}"
