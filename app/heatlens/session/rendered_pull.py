"""The frames of the shot as they are rendered: kept, counted, rendered while nothing else is to do.

Played from here, a frame is taken to the GPU and rendered no more.
"""

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Protocol

from heatlens.errors import HeatlensError
from heatlens.faults import faults_told
from heatlens.model.frames import FrameRange
from heatlens.preview.shown import Shown
from heatlens.rendered_frames.disk_store import DiskStore
from heatlens.rendered_frames.frame_filler import FrameFiller, FrameJob
from heatlens.rendered_frames.frame_order import frames_from, runs_of
from heatlens.rendered_frames.frame_store import MEGABYTE, FrameStore, memory_bytes_of
from heatlens.rendered_frames.memory_store import MemoryStore
from heatlens.session.editing import Editing
from heatlens.session.open_source import OpenSource
from heatlens.session.picture_view import PictureView
from heatlens.session.preferences import Preferences, Remembered
from heatlens.session.pull_jobs import PullJobs
from heatlens.session.timeline import Timeline

_SLICE_S = 0.02  # of work before the loop looks for input again
_REST_S = 0.3  # after what the user did, until frames are rendered
_KEYS_S = 0.004  # for the keys of frames, in each frame of the window
_FRAMES_MOST = 4000  # that are looked after at a time
_AHEAD = 24  # frames that are read from the disk ahead of the playhead
_PIXEL_BYTES = 8  # four half floats


def store_of(now: Remembered, folder: Path | None, wake: Callable[[], None]) -> FrameStore:
    """Return a store with the bounds that the user set; without a folder in memory alone."""
    memory = MemoryStore(memory_bytes_of(now.memory_mb))
    disk = None if folder is None else DiskStore(folder, now.disk_mb * MEGABYTE)
    return FrameStore(memory, disk, wake)


class ScreenWork(Protocol):
    """What whoever draws the frames does with them while nothing else is to do."""

    @property
    def has_work(self) -> bool:
        """Return True while a frame at hand is not ready for the screen."""

    def shown(self) -> Shown | None:
        """Return the picture of the frame at the playhead, where it was rendered before."""

    def prepare(self) -> None:
        """Make one frame more ready for the screen."""

    def begin(self) -> None:
        """Forget all frames: something else was opened, or they were cleared."""


class NoScreen:
    """Stands in while nobody draws: a frame at hand is as ready as it will be."""

    has_work = False

    def shown(self) -> Shown | None:
        """Return None: no picture lies on the GPU."""
        return None

    def prepare(self) -> None:
        """Do nothing."""

    def begin(self) -> None:
        """Do nothing."""


class RenderedPull:
    """Renders and keeps the frames that are played, as many of them as there is room for."""

    def __init__(
        self,
        jobs: PullJobs,
        store: FrameStore,
        source: OpenSource,
        editing: Editing,
        timeline: Timeline,
        view: PictureView,
        preferences: Preferences,
        is_busy: Callable[[], bool] = lambda: False,
        wake: Callable[[], None] = lambda: None,
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        """Take `is_busy`, which returns whether other work comes first."""
        self.jobs = jobs
        self.store = store
        self._source = source
        self._editing = editing
        self._timeline = timeline
        self._view = view
        self._preferences = preferences
        self._is_busy = is_busy
        self._wake = wake
        self._clock = clock
        self.screen: ScreenWork = NoScreen()  # whoever draws puts its own here
        self.version = 0  # counts the frames that were rendered
        self._filler: FrameFiller | None = None
        self._order: tuple[int, ...] = ()
        self._ordered: object = None  # what is played, and how many frames can be kept
        self.counted: object = None  # what the frames below were counted of
        self.rendered: frozenset[int] = frozenset()
        self.runs: tuple[FrameRange, ...] = ()
        self._missing: list[FrameJob] = []
        self._refused: set[str] = set()  # keys of frames that cannot be rendered
        self._made: set[str] = set()  # keys that were made since the user did something
        self._rests_at = 0.0
        self.keys: frozenset[str] = frozenset()  # of all frames that are looked after

    # What there is

    @property
    def is_on(self) -> bool:
        """Return True where there are frames to be played, and they are to be kept."""
        source = self._source
        if (
            not self._preferences.now.keep_frames
            or source.plate is None
            or not source.is_repeatable
        ):
            return False
        return self._view.is_drawn and self._timeline.played.count > 1  # else of unknown size

    @property
    def wanted(self) -> int:
        """How many frames are to be rendered: those that are played, as far as they are kept."""
        return len(self._order)

    def has(self, frame: int) -> bool:
        """Return True where the frame was rendered, wherever its picture lies."""
        job = self.jobs.of(frame) if self.is_on else None
        return job is not None and job.key in self.store.known()

    def is_at_hand(self, frame: int) -> bool:
        """Return True where the frame's picture lies in memory."""
        job = self.jobs.of(frame) if self.is_on else None
        return job is not None and self.store.get(job.key) is not None

    @property
    def is_alone(self) -> bool:
        """Return True while it plays and the frame at the playhead was rendered before."""
        return (
            bool(self._timeline.playback.direction)
            and self.fits_view
            and self._editing.performance is None
            and self.has(self._editing.frame)
        )

    @property
    def fits_view(self) -> bool:
        """Return True where the picture through the lens is seen, and nothing beside or over it."""
        return self._view.is_lens_alone

    def at_hand(self, keys: frozenset[str]) -> Iterator[FrameJob]:
        """Return the jobs of frames whose pictures have these keys, in the order of playing."""
        jobs = (self.jobs.of(frame) for frame in self._order)
        return (job for job in jobs if job is not None and job.key in keys)

    # What happens by itself

    def poll(self) -> None:
        """See what has changed and what is needed next; call this once a frame."""
        if not self.is_on:
            self._order, self.rendered, self.runs, self._missing = (), frozenset(), (), []
            self.counted = None
            return
        self._put_in_order()
        self.jobs.update(self._order)
        self.jobs.make(self._order, _KEYS_S)
        self._count()
        self._fetch()

    def _put_in_order(self) -> None:
        """Put the frames in the order of rendering; while it plays, their order waits."""
        timeline = self._timeline
        most = min(_FRAMES_MOST, max(1, self.store.capacity(self.picture_bytes)))
        wanted = timeline.played, most
        if wanted != self._ordered or not timeline.playback.direction:
            self._ordered = wanted
            self._order = frames_from(self._editing.frame, timeline.direction, *wanted)

    @property
    def picture_bytes(self) -> int:
        """What one frame takes in memory."""
        width, height = self.jobs.size
        return width * height * _PIXEL_BYTES

    def _count(self) -> None:
        """Find which frames are rendered and which are not, where that has changed."""
        made_of = (self.store.version, self.jobs.version, self._order)
        if made_of == self.counted:
            return
        self.counted, known = made_of, self.store.known()
        jobs = [job for frame in self._order if (job := self.jobs.of(frame))]
        self.rendered = frozenset(job.frame for job in jobs if job.key in known)
        self.runs = runs_of(self.rendered)
        self._missing = [job for job in jobs if job.key not in known]
        self.keys = frozenset(job.key for job in jobs)

    def _fetch(self) -> None:
        """Have what is played next in memory."""
        timeline = self._timeline
        direction = timeline.playback.direction
        most = self.store.memory.limit_bytes // (2 * self.picture_bytes)
        most = min(_AHEAD if direction else 2, most)
        ahead = frames_from(
            self._editing.frame, direction or timeline.direction, timeline.played, most
        )
        jobs = (self.jobs.of(frame) for frame in ahead)
        self.store.fetch([job.key for job in jobs if job is not None])

    def touched(self) -> None:
        """Note that the user did something: frames are rendered when that is over."""
        self._rests_at = self._clock() + _REST_S
        self._made.clear()

    def seconds_until_needed(self) -> float | None:
        """Return how long until frames are rendered; None: until there is news."""
        if not self.has_work:
            return None
        return max(0.0, self._rests_at - self._clock())

    @property
    def has_work(self) -> bool:
        """Return True where a frame could be rendered now, if the user rests."""
        if self._timeline.playback.direction or self._is_busy() or not self.is_on:
            return False
        if self._next() is None:
            return self.screen.has_work
        is_reading = self._filler is not None and self._filler.is_reading
        return not is_reading and self.store.has_room

    def _next(self, after: int = 0) -> FrameJob | None:
        """Return the frame that is to be rendered next, or the one `after` it."""
        known = self._refused | self._made
        found = (job for job in self._missing if job.key not in known)
        return next((job for at, job in enumerate(found) if at == after), None)

    def work(self) -> None:
        """Go on with the next frame for a moment, if the user rests.

        No error is raised: what cannot be rendered is said where it is seen.
        """
        self._count()
        job = self._next()
        if job is None:
            self._let_go()
            self.screen.prepare()
        elif self.has_work and self._clock() >= self._rests_at:
            self._work(job)

    def _work(self, job: FrameJob) -> None:
        try:
            with faults_told("A frame could not be rendered ahead"):
                picture = self._ready_filler().work(job, self._next(1), _SLICE_S)
        except HeatlensError:
            self._refused.add(job.key)
            return
        if picture is not None:
            self._made.add(job.key)
            self.store.put(job.key, picture)
            self.version += 1

    def _ready_filler(self) -> FrameFiller:
        """Return the filler, with the scene in front of its lens where there is one."""
        main = self._source.renderer
        if self._filler is None:
            self._filler = FrameFiller(main.beside(), self._wake)
        if main.scene is not self._filler.renderer.scene:
            self._filler.let_go()
            if main.scene is not None:
                self._filler.renderer.load_scene_of(main)
        return self._filler

    def _let_go(self) -> None:
        """Give the GPU's memory to others while there is nothing to render."""
        if self._filler is not None:
            self._filler.let_go()

    def begin(self) -> None:
        """Give up what is half done: something else was opened."""
        self._let_go()
        self._refused.clear()
        self._made.clear()
        self.screen.begin()

    # What the user may do with it

    def clear(self) -> None:
        """Forget every frame that was rendered, of this shot and of all others."""
        self.store.clear()
        self.screen.begin()
        self._made.clear()
        self._refused.clear()

    def switch(self) -> None:
        """Render frames ahead from now on, or no more."""
        self._preferences.change(keep_frames=not self._preferences.now.keep_frames)

    def resize(self, memory_mb: int, disk_mb: int) -> None:
        """Keep so much and no more."""
        self.store.resize(memory_bytes_of(memory_mb), disk_mb * MEGABYTE)

    def close(self) -> None:
        """End the threads; what waits to be written is written."""
        if self._filler is not None:
            self._filler.close()
        self.jobs.close()
        self.store.close()
