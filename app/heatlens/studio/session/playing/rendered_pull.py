"""Render the frames of the shot ahead while idle, and keep them for playback.

A kept frame only has to be uploaded to play, not rendered again.
"""

import time
from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from pathlib import Path

from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.faults import faults_reported
from heatlens.render.preview.shown import Shown
from heatlens.render.rendered_frames.frame_filler import FrameFiller, FrameJob
from heatlens.render.rendered_frames.frame_key import NO_ORDER, PlayOrder
from heatlens.render.rendered_frames.frame_store import MEGABYTE, FrameStore, memory_bytes_of
from heatlens.render.rendered_frames.kept_pictures import DiskStore, MemoryStore
from heatlens.studio.session.messages import Worker
from heatlens.studio.session.pictures.picture_view import PictureView
from heatlens.studio.session.playing.cluster_frames import ClusterFrames
from heatlens.studio.session.playing.pull_jobs import Progress, PullJobs, Wanted, progress_of
from heatlens.studio.session.settings.preferences import Remembered
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.time.timeline import Timeline

_SLICE_S = 0.02  # longest work before the loop handles input again
_REST_S = 0.3  # pause after user input before frames are rendered
_KEYS_S = 0.004  # time to compute the keys of frames, before the loop handles input again
_FRAMES_MOST = 4000  # largest number of frames to keep track of
_AHEAD = 24  # frames read from disk ahead of the playhead
_PIXEL_BYTES = 8  # four half floats


def store_of(now: Remembered, folder: Path | None, wake: Callable[[], None]) -> FrameStore:
    """Return a store with the user's limits; without a folder it keeps frames in memory only."""
    memory = MemoryStore(memory_bytes_of(now.memory_mb))
    disk = None if folder is None else DiskStore(folder, now.disk_mb * MEGABYTE)
    return FrameStore(memory, disk, wake)


class ScreenWork:
    """What the interface does with kept frames; the base does nothing, for want of a window."""

    @property
    def has_work(self) -> bool:
        """Return True while a frame in memory is not yet converted for the screen."""
        return False

    def shown(self) -> Shown | None:
        """Return the kept picture of the frame at the playhead; None if there is none."""
        return None

    def prepare(self) -> None:
        """Convert one more frame for the screen."""

    def begin(self) -> None:
        """Forget all frames, because another source was opened or they were cleared."""


class RenderedPull(Commands, Worker):
    """Renders and keeps the played frames, as many as the limits allow."""

    def __init__(
        self,
        shared: Shared,
        jobs: PullJobs,
        store: FrameStore,
        timeline: Timeline,
        view: PictureView,
        is_busy: Callable[[], bool],
        is_turning: Callable[[], bool],
    ) -> None:
        """Create it; `is_busy` returns True while more urgent work is waiting.

        `is_turning` returns True while a lens ring is being turned, which counts as user input.
        """
        super().__init__(shared)
        self.jobs, self.store = jobs, store
        self.cluster = ClusterFrames(shared, jobs, store)
        self._timeline, self._view, self._is_busy = timeline, view, is_busy
        self._is_turning = is_turning
        self._clock = time.perf_counter
        self.screen = ScreenWork()  # set by the interface
        self.frames_made = 0  # rendered since the start, so that the window draws each of them
        self._filler: FrameFiller | None = None
        self._order = NO_ORDER
        self.progress = Progress()
        self.is_counting = False  # keys of frames are still to be computed
        self._refused: set[str] = set()  # keys of frames that cannot be rendered
        self._made: set[str] = set()  # keys computed since the last user input
        self._rests_at = 0.0

    # State

    @property
    def is_on(self) -> bool:
        """Return True if there are frames to be played, and they are to be kept."""
        source = self._source
        if not self._preferences.now.keep_frames or source.plate is None or source.once_only:
            return False
        return self._view.is_drawn and self._timeline.played.count > 1  # the size is known

    @property
    def wanted(self) -> int:
        """The number of frames to render: all played ones, or as many as the limits allow."""
        return len(self._order.frames)

    def has(self, frame: int) -> bool:
        """Return True if the frame has been rendered, in memory or on disk."""
        job = self.jobs.of(frame) if self.is_on else None
        return job is not None and job.key in self.store.known()

    def is_at_hand(self, frame: int) -> bool:
        """Return True if the frame's picture is in memory."""
        job = self.jobs.of(frame) if self.is_on else None
        return job is not None and self.store.memory.get(job.key) is not None

    @property
    def is_alone(self) -> bool:
        """True while kept frames play, so that the live picture is not needed."""
        return (
            bool(self._timeline.playback.direction)
            and self._view.is_lens_alone
            and self._editing.performance is None
            and self.has(self._editing.frame)
        )

    # Called by the session

    def poll(self) -> None:
        """Update after changes and read frames that are needed next; call this once a frame."""
        if self._is_turning():
            self.touched()
        self.cluster.poll(self.is_on)
        if not self.is_on:
            self._order, self.progress, self.is_counting = NO_ORDER, Progress(), False
            self.cluster.keep(())
            return
        self._put_in_order()
        self.jobs.update(self._order.frames)
        self._count()
        self._share()
        self._fetch()

    def _put_in_order(self) -> None:
        """Sort the frames into rendering order, except during playback."""
        timeline = self._timeline
        most = min(_FRAMES_MOST, max(1, self.store.capacity(self.picture_bytes)))
        order = PlayOrder(self._editing.frame, timeline.direction, timeline.played, most)
        now, is_playing = self._order, bool(timeline.playback.direction)
        is_kept = is_playing and (order.played, order.most) == (now.played, now.most)
        if order != now and not is_kept:
            self._order = order

    @property
    def picture_bytes(self) -> int:
        """The memory of one frame in bytes."""
        width, height = self.jobs.size
        return width * height * _PIXEL_BYTES

    # After each change of a drag all frames have new keys. Computed at once they took 50 to 150 ms
    # in the demo, so they are made for a few milliseconds a turn, and the rest follows while
    # nothing else is to do. What is known so far is counted meanwhile: the blue line under the
    # ruler grows instead of waiting for the last key.
    def _count(self) -> None:
        """Update which frames are rendered and which are not, as far as their keys are known."""
        jobs, order = self.jobs, self._order
        self.is_counting = not jobs.make(order.frames, _KEYS_S)
        wanted = Wanted(jobs.made_of, order, jobs.count, self.store.version)
        if wanted != self.progress.wanted:
            self.progress = progress_of(wanted, jobs.made(order.frames), self.store.known())

    # A change of the shot changes the keys, so workers are told to recall frames under the old ones
    # at once, even while the user does not rest. A list of wishes takes the place of the last one,
    # so it is sent only at rest.
    def _share(self) -> None:
        """Take frames that workers have rendered; once the user rests, ask for the missing ones."""
        rests = self._clock() >= self._rests_at
        if self.is_counting:
            if not rests:
                self.cluster.keep(())
            return
        progress = self.progress
        for key in self.cluster.arrived(progress.keys):
            self._made.add(key)
            self.frames_made += 1
        if rests:
            self.cluster.ask(self._unknown(progress.missing), progress.wanted)
        else:
            self.cluster.keep(progress.keys)

    def _fetch(self) -> None:
        """Read the frames that are played next into memory."""
        timeline = self._timeline
        direction = timeline.playback.direction
        most = self.store.memory.limit_bytes // (2 * self.picture_bytes)
        most = min(_AHEAD if direction else 2, most)
        direction = direction or timeline.direction
        ahead = PlayOrder(self._editing.frame, direction, timeline.played, most)
        jobs = (self.jobs.of(frame) for frame in ahead.frames)
        self.store.fetch([job.key for job in jobs if job is not None])

    def touched(self) -> None:
        """Note user input, after which rendering ahead pauses."""
        self._rests_at = self._clock() + _REST_S
        self._made.clear()

    def seconds_until_needed(self) -> float | None:
        """Return the seconds until a frame can be rendered; None if there is none to render."""
        if not self.has_work and (not self.is_on or self.cluster.has_asked(self.progress.wanted)):
            return None
        return max(0.0, self._rests_at - self._clock())

    @property
    def has_work(self) -> bool:
        """Return True if there is a frame to render once the user rests."""
        if self._timeline.playback.direction or self._is_busy() or not self.is_on:
            return False
        if self._next() is None:
            return self.is_counting or self.screen.has_work
        is_reading = self._filler is not None and self._filler.is_reading
        return not is_reading and self.store.has_room

    def _next(self, after: int = 0) -> FrameJob | None:
        """Return the next frame to render, or the one after `after`."""
        return next(
            islice(self._unknown(self.cluster.left(self.progress.missing)), after, None), None
        )

    def _unknown(self, jobs: Iterable[FrameJob]) -> Iterator[FrameJob]:
        known = self._refused | self._made
        return (job for job in jobs if job.key not in known)

    def work(self) -> None:
        """Continue with the next frame for one slice, if the user rests.

        Errors are not raised here; they are reported when the frame is shown.
        """
        self._count()
        job = self._next()
        if self.is_counting:
            return
        if job is None:
            self._let_go()
            self.screen.prepare()
        elif self.has_work and self._clock() >= self._rests_at:
            self._work(job)

    # A frame that raises is refused until another source is opened: it would fail again in each
    # slice, and keep the frames behind it from being rendered. Why it fails is said when it is
    # shown, where the user can act on it.
    def _work(self, job: FrameJob) -> None:
        try:
            with faults_reported("A frame could not be rendered ahead"):
                picture = self._ready_filler().work(job, self._next(1), _SLICE_S)
        except HeatlensError:
            self._refused.add(job.key)
            return
        if picture is not None:
            self._made.add(job.key)
            self.store.put(job.key, picture)
            self.frames_made += 1

    def _ready_filler(self) -> FrameFiller:
        """Return the filler, loaded with the scene if one is open."""
        main = self._source.picture.renderer
        if self._filler is None:
            self._filler = FrameFiller(main.beside(), self._wake)
        if main.scene is not self._filler.renderer.scene:
            self._filler.let_go()
            if main.has_many_views:
                self._filler.renderer.load_scene_of(main)
        return self._filler

    def _let_go(self) -> None:
        """Free the GPU memory while there is nothing to render."""
        if self._filler is not None:
            self._filler.let_go()

    def begin(self) -> None:
        """Discard unfinished work, because another source was opened."""
        self._let_go()
        self._refused.clear()
        self._made.clear()
        self.cluster.begin()
        self.screen.begin()

    # Commands

    def clear(self) -> None:
        """Delete all kept frames, of this shot and of all others."""
        self.store.clear()
        self.screen.begin()
        self._made.clear()
        self._refused.clear()

    @property
    def kept(self) -> Remembered:
        """The preferences, which have the limits of kept frames."""
        return self._preferences.now

    def switch(self) -> None:
        """Switch rendering ahead on or off."""
        self._preferences.change(keep_frames=not self._preferences.now.keep_frames)

    def resize(self, memory_mb: int, disk_mb: int) -> None:
        """Set the limits for kept frames in MB."""
        self._preferences.change(memory_mb=memory_mb, disk_mb=disk_mb)
        self.store.resize(memory_bytes_of(memory_mb), disk_mb * MEGABYTE)

    def close(self) -> None:
        """Finish writing and end the threads."""
        if self._filler is not None:
            self._filler.close()
        self.cluster.close()
        self.jobs.close()
        self.store.close()
