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
from heatlens.core.base.faults import told_error
from heatlens.deliver.farm.answers import answer_of
from heatlens.deliver.farm.connection import Met, connected, is_loss, not_data
from heatlens.deliver.farm.dask_types import Client, Future
from heatlens.deliver.farm.data_only import NotDataError
from heatlens.deliver.farm.frame_worker import (
    Program,
    picture_in,
    program_in,
    program_of,
    program_on,
    rendered,
    sent,
)
from heatlens.render.defocus.line_solver import SolverName
from heatlens.render.rendered_frames.frame_filler import FrameJob
from heatlens.render.rendered_frames.kept_pictures import KeptPicture, RenderedPicture

_LOOK_S = 1.0  # interval between checks for new and lost workers
_AGAIN_S = 10.0  # after a failure, time until the scheduler is tried again
_WAITING = 2  # frames that each worker has, so that none waits for the next
_FIRST = 10  # priority of a picture that somebody waits for

ON_THIS_MACHINE = "Frames are rendered on this machine."


@dataclass(frozen=True)
class Wish:
    """A frame that is wanted.

    key      no other frame that is wanted has it
    make     returns its job; called on a thread, because it may look for files
    is_kept  it is to be kept, in half floats; otherwise somebody waits for it
    """

    key: str
    make: Callable[[], FrameJob]
    is_kept: bool = True


@dataclass(frozen=True)
class Answer:
    """A frame that a worker has rendered; or why it could not."""

    key: str
    picture: RenderedPicture | KeptPicture | None
    problem: str = ""


# Every call of Dask's client may wait for the network, or for a scheduler that has gone, and a
# window may not wait. So one thread alone has the client; the window writes wishes and reads
# answers under a lock that is never held during a call.
class FrameCluster:
    """The frames of one window at one scheduler."""

    def __init__(
        self,
        address: str,
        here: tuple[str, str, SolverName],
        wake: Callable[[], None],
        agreed: Met | None = None,
    ) -> None:
        """Begin to connect. `here` is the OpenGL driver of the window, its version, and the solver.

        `wake` is called on a thread when there is news. No other scheduler is used than `agreed`,
        nor in another network, before `agree` is called.
        """
        self.address, self.here = address, here
        self.asks: Met | None = None  # the scheduler that answers, until the user agrees to it
        self._agreed = agreed
        self.workers: tuple[str, ...] = ()  # that render
        self.problem = ""  # a sentence why none renders, or ""
        self.program: Program = ()  # of the workers, if it is not that of this machine
        self._wake = wake
        self._lock = threading.Lock()  # guards the wishes and the answers
        self._wanted: tuple[Wish, ...] = ()
        self._answers: list[Answer] = []
        self._first: Wish | None = None  # a picture that somebody waits for, and its answer
        self._first_answer: Answer | None = None
        self._news: queue.SimpleQueue[Future | None] = queue.SimpleQueue()
        self._closed = threading.Event()
        self._again = threading.Event()  # it need not wait before it connects
        self._thread = Threads("frames-cluster")
        self._thread.submit(self._run)

    # Called by the window

    def ask(self, wishes: Iterable[Wish]) -> None:
        """Want these frames, in this order, and no others: those under way are recalled."""
        with self._lock:
            self._wanted = tuple(wishes)
        self.hear(None)

    def ask_first(self, wish: Wish | None) -> None:
        """Want this picture before all others, and none that was wanted so before."""
        with self._lock:
            self._first, self._first_answer = wish, None
        self.hear(None)

    @property
    def first_answer(self) -> Answer | None:
        """The answer to the latest `ask_first`; None before it is there."""
        with self._lock:
            return self._first_answer

    def keep(self, keys: Container[str]) -> None:
        """Recall all frames but those with these keys."""
        wanted = [wish for wish in self.wanted() if wish.is_kept]
        kept = [wish for wish in wanted if wish.key in keys]
        if len(kept) != len(wanted):
            self.ask(kept)

    def taken(self) -> list[Answer]:
        """Return the answers that have arrived since the last call."""
        with self._lock:
            answers, self._answers = self._answers, []
        return answers

    def agree(self) -> Met | None:
        """Use the scheduler that answers; return it."""
        self._agreed, self.asks = self.asks, None
        self._again.set()
        return self._agreed

    def close(self) -> None:
        """Recall everything, without waiting for it."""
        self._closed.set()
        self._again.set()
        self.ask(())
        self.ask_first(None)
        self._thread.close()

    # Called by its thread

    @property
    def is_closed(self) -> bool:
        """True once the window needs it no more."""
        return self._closed.is_set()

    @property
    def waiting(self) -> int:
        """The number of answers that the window has not taken."""
        with self._lock:
            return len(self._answers)

    def wanted(self) -> tuple[Wish, ...]:
        """Return the frames that have no answer yet."""
        with self._lock:
            answered = {it.key for it in self._answers}
            first = () if self._first is None else (self._first,)
            return first + tuple(wish for wish in self._wanted if wish.key not in answered)

    def hear(self, future: Future | None) -> None:
        """Take a finished future, or None to look at the wishes again."""
        self._news.put(future)

    def news(self, seconds: float) -> list[Future | None]:
        """Return what was heard, after waiting for it so long at most."""
        heard = []
        with suppress(queue.Empty):
            heard.append(self._news.get(timeout=seconds))
            while True:
                heard.append(self._news.get_nowait())
        return heard

    def answer(self, answers: Sequence[Answer]) -> None:
        """Hand answers to the window, which takes each frame off its wishes."""
        if answers:
            by_key = {it.key: it for it in answers}
            with self._lock:
                if self._first is not None and self._first.key in by_key:
                    self._first_answer = by_key.pop(self._first.key)
                    self._first = None
                self._wanted = tuple(it for it in self._wanted if it.key not in by_key)
                self._answers += by_key.values()
            self._wake()

    def tell(self, workers: tuple[str, ...], problem: str, program: Program = ()) -> None:
        """Tell the window who renders."""
        now = workers, problem, program
        if now != (self.workers, self.problem, self.program):
            self.workers, self.problem, self.program = now
            self._wake()

    def _run(self) -> None:
        """Serve wishes until it is closed; runs on a thread."""
        while not self.is_closed:
            try:
                with connected(self.address, self._check) as client:
                    _Service(self, client).run()
            except HeatlensError as error:
                self.tell((), f"{error} {ON_THIS_MACHINE}")
            except NotDataError:
                self.tell((), f"{not_data(self.address)} {ON_THIS_MACHINE}")
            except Exception as error:
                gone = f"The scheduler at {self.address} has gone."
                sentence = gone if is_loss(error) else told_error(error, "Dask failed")
                self.tell((), f"{sentence} {ON_THIS_MACHINE}")
            self._again.wait(_AGAIN_S)
            self._again.clear()

    def _check(self, met: Met) -> None:
        """Raise InputError for a scheduler or a network to which the user has not agreed."""
        self.asks = None if met == self._agreed else met
        if self.asks is None:
            return
        other = self._agreed
        if other is None or other.scheduler != met.scheduler:
            why = "is new to this window"
        elif other.own_host != met.own_host:
            why = f"is reached from {met.own_host}, and was from {other.own_host}"
        else:
            why = "is another than before, or was started again"
        raise InputError(f"The scheduler at {self.address} {why}: agree to it in the Export tab.")


@dataclass(frozen=True, eq=False)
class _UnderWay:
    """A frame that was sent; `workers` are those that may render it."""

    wish: Wish
    future: Future
    workers: frozenset[str]


class _Service:
    """One connection to the scheduler, on the thread of a `FrameCluster`."""

    def __init__(self, of: FrameCluster, client: Client) -> None:
        self._of, self._client = of, client
        self._programs: dict[str, Future] = {}  # futures of the program of each worker
        self._known: dict[str, Program] = {}  # as the workers have named them
        self._failed: dict[str, str] = {}  # why a worker has named none
        self._look_at = 0.0  # time of the next check of the workers
        self._under_way: dict[str, _UnderWay] = {}  # by the key of the frame
        self._here = program_on(*of.here)

    def run(self) -> None:
        """Serve until the connection breaks or the window has closed."""
        while not self._of.is_closed and self._client.status == "running":
            if time.monotonic() >= self._look_at:
                self._look_at_workers()
            wanted = self._of.wanted()
            self._recall({wish.key for wish in wanted})
            self._send(wanted)
            self._take(self._of.news(_LOOK_S))
        if not self._of.is_closed:
            raise ConnectionError

    def _take(self, news: Sequence[Future | None]) -> None:
        """Pass on what the workers have finished."""
        done = {id(future) for future in news if future is not None}
        finished = [it for it in self._under_way.values() if id(it.future) in done]
        for it in finished:
            del self._under_way[it.wish.key]
        self._of.answer([answer for it in finished for answer in _answers(it)])

    def _recall(self, wanted: set[str]) -> None:
        """Cancel frames that are not wanted any more, or whose workers have all gone."""
        there = set(self._of.workers)
        recalled = [
            key
            for key, it in self._under_way.items()
            if key not in wanted or not it.workers & there
        ]
        if recalled:
            self._client.cancel([self._under_way.pop(key).future for key in recalled])

    def _send(self, wanted: Sequence[Wish]) -> None:
        """Send as many frames as the workers can have at once."""
        workers = self._of.workers
        room = _WAITING * len(workers) - len(self._under_way) - self._of.waiting
        left = [wish for wish in wanted if wish.key not in self._under_way]
        is_awaited = bool(left) and not left[0].is_kept
        for wish in left[: max(0, room, is_awaited)]:
            self._send_one(wish, workers)

    def _send_one(self, wish: Wish, workers: Sequence[str]) -> None:
        try:
            job = sent(wish.make())
        except HeatlensError as error:
            self._of.answer([Answer(wish.key, None, str(error))])
            return
        task = {"pure": False, "workers": list(workers), "priority": 0 if wish.is_kept else _FIRST}
        future = self._client.submit(rendered, job, self._of.here[2], wish.is_kept, **task)
        self._under_way[wish.key] = _UnderWay(wish, future, frozenset(workers))
        future.add_done_callback(self._of.hear)

    def _look_at_workers(self) -> None:
        """Ask new workers for their programs, and use those that draw as this machine does.

        If there are none, use those that draw as the first of them.
        """
        self._look_at = time.monotonic() + _LOOK_S
        there = self._client.scheduler_info(n_workers=-1)["workers"]
        self._programs = {it: future for it, future in self._programs.items() if it in there}
        for worker in [it for it in there if it not in self._programs]:
            task = {"pure": False, "workers": [worker], "priority": _FIRST}
            self._programs[worker] = self._client.submit(program_of, self._of.here[2], **task)
            self._programs[worker].add_done_callback(self._look_soon)
        self._choose()

    def _look_soon(self, _future: Future) -> None:
        self._look_at = 0.0
        self._of.hear(None)

    def _learn_programs(self) -> None:
        """Forget the programs of workers that are gone, and keep those that workers have named."""
        self._known = {it: program for it, program in self._known.items() if it in self._programs}
        self._failed = {it: why for it, why in self._failed.items() if it in self._programs}
        for it, future in self._programs.items():
            is_new = it not in self._known and it not in self._failed
            if is_new and future.status in ("finished", "error"):
                self._learn(it, future)

    def _learn(self, worker: str, future: Future) -> None:
        try:
            answer = answer_of(future)
            if answer is not None:
                self._known[worker] = program_in(answer)
        except HeatlensError as error:
            self._failed[worker] = str(error)

    # Two drivers draw the same frame with other last digits, and a shot is not made of both. So the
    # workers that render are all of one program, if possible that of this machine, whose frames the
    # window renders too.
    def _choose(self) -> None:
        self._learn_programs()
        fit = {it: own for it, own in self._known.items() if own[:2] == self._here[:2]}
        program = self._here if self._here in fit.values() else next(iter(fit.values()), ())
        workers = tuple(it for it, own in fit.items() if own == program)
        is_asking = any(future.status == "pending" for future in self._programs.values())
        why = "" if workers or is_asking else f"{self._why_none} {ON_THIS_MACHINE}"
        self._of.tell(workers, why, () if program == self._here else program)

    @property
    def _why_none(self) -> str:
        if not self._programs:
            return f"No worker is at {self._of.address}."
        return next(
            iter(self._failed.values()),
            f"The workers at {self._of.address} have another heatlens.",
        )


def _answers(sent: _UnderWay) -> Iterator[Answer]:
    """Yield the answer of a worker; none if the frame was recalled, or it died with its answer."""
    key = sent.wish.key
    try:
        answer = answer_of(sent.future)
        picture = None if answer is None else picture_in(answer)
    except HeatlensError as error:
        yield Answer(key, None, str(error))
    else:
        if picture is not None:
            yield Answer(key, picture)
