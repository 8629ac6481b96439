"""Keep the frames of a sequence in memory, and read those that are shown next on threads."""

import math
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Literal

from heatlens.core.base.background import Threads
from heatlens.core.base.closing import Closing
from heatlens.core.base.errors import HeatlensError
from heatlens.media.frame_cache.plate_shelf import (
    CachedPlate,
    Damaged,
    Direction,
    PlateShelf,
    PlayOrder,
    Stamps,
    plate_bytes,
)
from heatlens.media.plate.plate import Plate
from heatlens.media.sequence.sequence import Sequence, stamp_of
from heatlens.media.sequence.sequence_search import rescan

__all__ = ["Damaged", "Direction", "FrameCache", "FrameState", "plate_bytes"]

# absent: on disk only; queued: to be read, but not yet begun; missing: the frame has no file.
FrameState = Literal["absent", "queued", "reading", "ready", "damaged", "missing"]


class FrameCache(Closing):
    """Plates of `sequence`, made by `read`, within `budget_bytes` of color and depth.

    `set_playhead` chooses the frames to read; `get` returns at once with whatever is in memory.
    `read` runs on up to `workers` threads at a time; the memory it needs while working is not
    counted. A HeatlensError makes the frame Damaged until its file changes. Any other exception is
    a fault of the program: reading stops, and every later `set_playhead`, `get`, `read_and_wait`
    and `refresh` raises it. `on_ready` is called without arguments on one of the threads whenever a
    state changes, and should only wake a loop. A frame larger than the budget is kept alone while
    the playhead is on it.

    If `keeps_passed` is False, frames are dropped as soon as the playhead has passed them, for a
    single pass over the sequence.

    One lock guards all changing fields; no file is accessed and no callback called under it.
    """

    def __init__(
        self,
        sequence: Sequence,
        read: Callable[[Path], Plate],
        budget_bytes: int,
        workers: int = 2,
        on_ready: Callable[[], None] = lambda: None,
        keeps_passed: bool = True,
        files_of: Callable[[Path], tuple[Path, ...]] = lambda path: (path,),
    ):
        self._read = read
        self._files_of = files_of
        self._workers = workers
        self._on_ready = on_ready
        self._keeps_passed = keeps_passed
        self._condition = threading.Condition(threading.Lock())
        self._sequence = sequence
        self._unread_states = _unread_states(sequence)
        # Before the first `set_playhead` no frame is read, not even that at the playhead.
        self._order = PlayOrder.at(sequence.frames, sequence.first, 1, window=-1)
        self._shelf = PlateShelf(budget_bytes)
        self._nearest_m = math.inf
        self._is_scanning = False
        self._problem: str | None = None
        self._failure: BaseException | None = None
        self._failure_trace: TracebackType | None = None
        self._is_closed = False
        # One thread more than concurrent reads, so that scanning the folder never waits for them.
        self._threads = Threads("frame-cache", workers + 1)

    @property
    def sequence(self) -> Sequence:
        """The sequence as it was at the last scan of the disk."""
        with self._condition:
            return self._sequence

    @property
    def problem(self) -> str | None:
        """A sentence on why the last scan of the disk failed, or None; known frames stay."""
        with self._condition:
            return self._problem

    @property
    def bytes_in_use(self) -> int:
        """Bytes of the pixels held, and of the space reserved for frames that are being read."""
        with self._condition:
            return self._shelf.bytes_in_use

    # Frames that were only read ahead count too, because the focus bar takes its scale from here.
    # Otherwise it grows on each frame with nearer surfaces while a shot plays for the first time.
    @property
    def nearest_m(self) -> float:
        """Metres to the nearest surface of all plates read so far; infinity where none has one."""
        with self._condition:
            return self._nearest_m

    def set_playhead(self, frame: int, direction: Direction = 1, window: int = 24) -> None:
        """Put the playhead on `frame`: read this first, then `window` frames in `direction`.

        The first frame follows the last, as in a looping player.
        """
        self._raise_failure()
        with self._condition:
            self._order = PlayOrder.at(self._sequence.frames, frame, direction, window)
            self._shelf.trim(self._order)
            if not self._keeps_passed:
                self._shelf.keep_only(set(self._order.frames_to_read()))
            self._begin_reads()
            self._condition.notify_all()

    def get(self, frame: int) -> Plate | Damaged | None:
        """Return `frame` if it is in memory, without waiting; None if it is not yet there."""
        self._raise_failure()
        with self._condition:
            cached = self._shelf.cached.get(frame)
        return cached.content if cached else None

    def read_and_wait(
        self, frame: int, direction: Direction = 1, window: int = 24
    ) -> Plate | Damaged | None:
        """Read `frame` and wait for it, as exports do, which leave no frame out.

        Returns None for a frame without a file, or when another thread moves the playhead or
        closes.
        """
        self.set_playhead(frame, direction, window)
        with self._condition:
            self._condition.wait_for(lambda: not self._is_coming(frame))
        return self.get(frame)

    def states(self) -> dict[int, FrameState]:
        """Return the state of every frame of the sequence, in order, for the timeline."""
        with self._condition:
            states = self._unread_states.copy()
            for frame in self._order.frames_to_read():
                if states[frame] == "absent":
                    states[frame] = "queued"
            states.update(dict.fromkeys(self._shelf.reserved, "reading"))
            for frame, cached in self._shelf.cached.items():
                states[frame] = "damaged" if isinstance(cached.content, Damaged) else "ready"
        return states

    def refresh(self) -> None:
        """Let a thread scan the disk for frames that were added, removed or written again.

        Returns at once. Frames whose files have changed are read again, and so are new ones if they
        are wanted.
        """
        self._raise_failure()
        with self._condition:
            if not (self._is_scanning or self._is_closed):
                self._is_scanning = True
                stamps = {frame: held.stamps for frame, held in self._shelf.cached.items()}
                self._threads.submit(self._scan_disk, self._sequence, stamps)

    def close(self) -> None:
        """Stop reading and free the frames that are held, without waiting for anything.

        A read that has begun goes on, because a disk cannot be interrupted; its frame is dropped.
        """
        with self._condition:
            self._is_closed = True
            self._shelf.cached.clear()
            self._condition.notify_all()
        self._threads.close()

    def _raise_failure(self) -> None:
        """Raise in the caller's thread the exception that stopped a worker thread."""
        with self._condition:
            failure, trace = self._failure, self._failure_trace
        if failure is not None:
            raise failure.with_traceback(trace)  # a kept traceback would grow with each call

    def _is_unread(self, frame: int) -> bool:
        """Return True for a frame with a file that is neither in memory nor being read.

        The caller holds the lock.
        """
        is_known = frame in self._shelf.cached or frame in self._shelf.reserved
        return not is_known and self._sequence.has_file(frame)

    def _is_coming(self, frame: int) -> bool:
        """Return True while waiting for `frame` makes sense; the caller holds the lock."""
        if self._is_closed or self._failure or self._order.playhead != frame:
            return False
        return frame in self._shelf.reserved or self._is_unread(frame)

    def _begin_reads(self) -> None:
        """Start reading the most wanted frames that fit into memory; the caller holds the lock."""
        if self._is_closed or self._failure:
            return
        for frame in filter(self._is_unread, self._order.frames_to_read()):
            if len(self._shelf.reserved) >= self._workers:
                return
            if not self._shelf.reserve(frame, self._order):
                return
            self._threads.submit(self._read_frame, frame, self._sequence.path_at(frame))

    # The lock is held for the bookkeeping alone, never for a file or a callback: the loop of the
    # window calls `get`, and a slow disk would stop the picture.
    def _read_frame(self, frame: int, path: Path) -> None:
        """Read `path` and put it on the shelf; runs on a thread."""
        with self._store_failure():
            stamps = self._stamps(path)  # before reading, so that a later write is noticed
            cached = CachedPlate(self._read_or_damaged(path), stamps)
            with self._condition:
                if self._is_closed:
                    del self._shelf.reserved[frame]
                    return
                self._nearest_m = min(self._nearest_m, _nearest_m(cached.content))
                self._shelf.put(frame, cached, self._order)
                del cached  # if the shelf drops the frame, its memory is free for the next one
                if not self._sequence.has_file(frame):
                    self._shelf.drop_changed(frame)  # the file was removed since the read began
                self._begin_reads()
                self._condition.notify_all()
            self._on_ready()

    def _read_or_damaged(self, path: Path) -> Plate | Damaged:
        """Return the plate at `path`, or Damaged with the reason if it cannot be read."""
        try:
            return self._read(path)
        except HeatlensError as error:
            return Damaged.of(path, error)

    def _stamps(self, path: Path) -> Stamps:
        """Return the stamps of all files that the plate at `path` is read from."""
        return tuple(stamp_of(file) for file in self._files_of(path))

    def _find_changed_frames(
        self, sequence: Sequence, stamps_by_frame: Mapping[int, Stamps]
    ) -> tuple[int, ...]:
        """Return the frames whose files have other stamps now than in `stamps_by_frame`."""
        items = stamps_by_frame.items()
        return tuple(it for it, old in items if self._stamps(sequence.path_at(it)) != old)

    def _scan_disk(self, sequence: Sequence, stamps_by_frame: Mapping[int, Stamps]) -> None:
        """Scan `sequence` and the files that were read for changes; runs on a thread."""
        with self._store_failure():
            try:
                scanned = rescan(sequence)
                changed_frames = self._find_changed_frames(sequence, stamps_by_frame)
                problem = None
            except HeatlensError as error:
                scanned, changed_frames, problem = sequence, (), str(error)
            with self._condition:
                if self._is_closed:
                    return
                is_same_scan = (scanned, problem) == (self._sequence, self._problem)
                self._is_scanning, self._problem = False, problem
                self._apply_scan(scanned, changed_frames)
                self._condition.notify_all()
            if changed_frames or not is_same_scan:
                self._on_ready()

    def _apply_scan(self, sequence: Sequence, changed_frames: tuple[int, ...]) -> None:
        """Use `sequence`, drop the changed frames and read on; the caller holds the lock."""
        self._sequence, self._unread_states = sequence, _unread_states(sequence)
        order = self._order
        self._order = PlayOrder.at(sequence.frames, order.playhead, order.direction, order.window)
        for frame in changed_frames:
            self._shelf.drop_changed(frame)
        self._begin_reads()

    @contextmanager
    def _store_failure(self) -> Iterator[None]:
        """Store an exception of the block, which callers of this object then raise; wake them."""
        try:
            yield
        except BaseException as error:
            with self._condition:
                self._failure, self._failure_trace = error, error.__traceback__
                self._condition.notify_all()
            self._on_ready()
            raise


def _nearest_m(content: Plate | Damaged) -> float:
    """Return meters to the nearest surface of a plate; infinity without distances or surfaces."""
    if isinstance(content, Damaged) or not content.has_distances:
        return math.inf
    return content.depth.near_m


def _unread_states(sequence: Sequence) -> dict[int, FrameState]:
    """Return the state of every frame before any is read."""
    states: dict[int, FrameState] = dict.fromkeys(sequence.frames, "missing")
    states.update(dict.fromkeys(sequence.present, "absent"))
    return states
