"""Track the surfaces of marks through the frames of a sequence, on a thread."""

from collections.abc import Callable
from dataclasses import dataclass
from threading import Event

from heatlens.core.base.background import Background
from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.base.messages import Problem, Worker
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.marks.marks import MarkAnchor
from heatlens.core.model.marks.track_mark import TrackMark
from heatlens.media.frame_cache.cache import FrameCache
from heatlens.media.plate.plate import Plate
from heatlens.media.plate.tracking.tracked_mark import track_mark
from heatlens.studio.session.marks.mark_distances import plate_at, reading_options
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.time.timeline import Timeline

Receiver = Callable[[tuple[Mark, ...], TrackMark], None]


@dataclass
class _Order:
    """A mark to be tracked through the frames of a cache.

    `marks` holds it as it was at the start, and as it is after each change since.
    """

    marks: tuple[Mark, ...]
    mark: TrackMark
    cache: FrameCache
    receive: Receiver


class SurfaceTracking(Commands, Worker):
    """Tracks the surfaces of marks through their sequence on a thread, one after the other."""

    def __init__(self, shared: Shared, timeline: Timeline) -> None:
        super().__init__(shared)
        self._timeline = timeline
        self._tracker: Background[TrackMark] = Background(self._wake)
        self._stop = Event()  # ends the tracking on the thread
        self._orders: list[_Order] = []  # the first one is at work
        self._frame = 0  # the frame that the thread reads

    @property
    def is_busy(self) -> bool:
        """True while a surface is followed, or waits for that."""
        return bool(self._orders)

    @property
    def words(self) -> str:
        """What is done now, such as "Following A, frame 1012"; "" without a mark."""
        names = [order.marks[-1].name for order in self._orders[:1]]
        return "".join(f"Following {name}, frame {self._frame}" for name in names)

    def follows(self, mark: Mark) -> bool:
        """Return True until the surface of a mark is known."""
        return any(mark in order.marks for order in self._orders)

    def is_awaited(self, mark: Mark, frame: int) -> bool:
        """Return True if the tracking will tell where a mark is at a frame; not a clicked one."""
        return any(
            mark in order.marks and all(click.frame != frame for click in order.mark.clicks)
            for order in self._orders
        )

    def start(self, old_mark: Mark, mark: TrackMark, receive: Receiver) -> None:
        """Track `mark` through all frames; `receive` gets the forms of `old_mark`, and the result.

        It replaces an earlier order for the same mark.
        """
        cache = self._timeline.cache
        if cache is not None:
            self._drop([order for order in self._orders if old_mark in order.marks])
            self._orders.append(_Order((old_mark,), mark, cache, receive))
            self._begin()

    def note_change(self, old_mark: Mark, new_mark: Mark) -> None:
        """Go on with a mark that was renamed meanwhile."""
        for order in self._orders:
            if order.marks[-1] == old_mark:
                order.marks = (*order.marks, new_mark)

    def stop(self, mark: Mark | None = None) -> None:
        """End the tracking of a mark, or of all; they stay as they were."""
        ended = [order for order in self._orders if mark is None or mark in order.marks]
        self._drop(ended)
        for order in ended:
            self._notify(f"The tracking is stopped. {_stays(order)}")

    def poll(self) -> None:
        """Hand over the mark that is tracked, and begin with the next; call this once a frame."""
        shown_marks, cache = self._editing.shot.marks, self._timeline.cache
        self._drop(
            [it for it in self._orders if it.cache is not cache or it.marks[-1] not in shown_marks]
        )
        try:
            tracked_mark = self._tracker.poll()
        except HeatlensError as error:
            self._notify(Problem(f"{_stays(self._orders.pop(0))} {error}"))
        else:
            if tracked_mark is not None:
                order = self._orders.pop(0)
                order.receive(order.marks, tracked_mark)
        self._begin()

    def _drop(self, dropped: list[_Order]) -> None:
        """End and forget some orders."""
        if self._orders and self._orders[0] in dropped:
            self._stop.set()
            self._tracker.cancel()
        self._orders = [order for order in self._orders if order not in dropped]

    def _begin(self) -> None:
        """Begin with the first order, unless the thread is at work."""
        frames = self._timeline.frames
        if not self._orders or self._tracker.is_busy or frames is None:
            return
        mark, cache = self._orders[0].mark, self._orders[0].cache
        stop, options = Event(), reading_options(self._source)
        self._stop, self._frame = stop, mark.clicks[0].frame

        def read_frame(frame: int) -> Plate:
            if stop.is_set():
                raise InputError("The tracking is stopped.")
            self._frame = frame
            self._wake()
            return plate_at(cache, options, frame)

        self._tracker.start(lambda: track_mark(mark, frames, read_frame, lambda _: None))


def _stays(order: _Order) -> str:
    """Return the sentence that a mark is as it was before its tracking."""
    mark = order.marks[-1]
    return f"Mark {mark.name} stays on the {MarkAnchor.of(mark)}."
