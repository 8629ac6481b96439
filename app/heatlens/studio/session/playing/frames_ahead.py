"""Render the frames of the shot ahead while idle, and keep them for playback.

A cached frame only has to be uploaded to play, not rendered again.
"""

import time
from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from pathlib import Path

from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.faults import report_faults
from heatlens.core.base.messages import Worker
from heatlens.core.model.view.picture_view import PictureView
from heatlens.render.rendered_frames.cached_pictures import DiskStore, MemoryStore
from heatlens.render.rendered_frames.frame_filler import FrameFiller, FrameJob
from heatlens.render.rendered_frames.frame_key import NO_ORDER, PlayOrder
from heatlens.render.rendered_frames.frame_store import MEGABYTE, FrameStore, memory_bytes_of
from heatlens.render.rendered_frames.screen_work import ScreenWork
from heatlens.studio.session.playing.ahead_jobs import (
    AheadJobs,
    FramesRequest,
    Progress,
    progress_of,
)
from heatlens.studio.session.playing.cluster_frames import ClusterFrames
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.time.timeline import Timeline
from heatlens.studio.settings.preferences import PreferenceValues

_SLICE_S = 0.02  # longest work before the loop handles input again
_REST_S = 0.3  # pause after user input before frames are rendered
_KEYS_S = 0.004  # time to compute the keys of frames, before the loop handles input again
_MAX_FRAMES = 4000  # largest number of frames to keep track of
_AHEAD = 24  # frames read from disk ahead of the playhead
_PIXEL_BYTES = 8  # four half floats


def store_of(
    preferences: PreferenceValues, folder: Path | None, wake: Callable[[], None]
) -> FrameStore:
    """Return a store with the user's limits; without a folder it keeps frames in memory only."""
    memory = MemoryStore(memory_bytes_of(preferences.memory_mb))
    disk = None if folder is None else DiskStore(folder, preferences.disk_mb * MEGABYTE)
    return FrameStore(memory, disk, wake)


class FramesAhead(Commands, Worker):
    """Renders and keeps the played frames, as many as the limits allow."""

    def __init__(
        self,
        shared: Shared,
        jobs: AheadJobs,
        store: FrameStore,
        cluster: ClusterFrames,
        timeline: Timeline,
        view: PictureView,
        is_busy: Callable[[], bool],
        is_turning: Callable[[], bool],
        make_screen: Callable[["FramesAhead"], ScreenWork],
    ) -> None:
        """Create it; `is_busy` returns True while more urgent work waits.

        `is_turning` returns True while a lens ring is being turned, which counts as user input.
        `make_screen` returns what shows the frames.
        """
        super().__init__(shared)
        self.jobs, self.store, self.cluster = jobs, store, cluster
        self._timeline, self._view, self._is_busy = timeline, view, is_busy
        self._is_turning = is_turning
        self._clock = time.perf_counter
        self.frames_made = 0  # rendered since the start, so that the window draws each of them
        self._filler: FrameFiller | None = None
        self._order = NO_ORDER
        self.progress = Progress()
        self.is_counting = False  # keys of frames are still to be computed
        self._refused_keys: set[str] = set()  # keys of frames that cannot be rendered
        self._made_keys: set[str] = set()  # keys computed since the last user input
        self._rest_from_s = 0.0
        self.screen = make_screen(self)

    # State

    @property
    def is_on(self) -> bool:
        """True if there are frames to be played, and they are to be kept."""
        source = self._source
        if (
            not self._preferences.values.keep_frames
            or source.plate is None
            or source.why_shown_once
        ):
            return False
        return self._view.is_drawn and self._timeline.played.count > 1  # the size is known

    @property
    def wanted_count(self) -> int:
        """The number of frames to render: all played ones, or as many as the limits allow."""
        return len(self._order.frames)

    def is_rendered(self, frame: int) -> bool:
        """Return True if the frame has been rendered, in memory or on disk."""
        job = self.jobs.job_of(frame) if self.is_on else None
        return job is not None and job.key in self.store.known_keys()

    def is_in_memory(self, frame: int) -> bool:
        """Return True if the frame's picture is in memory."""
        job = self.jobs.job_of(frame) if self.is_on else None
        return job is not None and self.store.memory.get(job.key) is not None

    @property
    def plays_cached_frames(self) -> bool:
        """True while cached frames play, so that the live picture is not needed."""
        return (
            bool(self._timeline.playback.direction)
            and self._view.is_lens_alone
            and self._editing.performance is None
            and self.is_rendered(self._editing.frame)
        )

    # Called by the session

    def poll(self) -> None:
        """Order the frames, update the progress and read ahead; call this once a frame."""
        if self._is_turning():
            self.note_input()
        self.cluster.poll(self.is_on)
        if not self.is_on:
            self._order, self.progress, self.is_counting = NO_ORDER, Progress(), False
            self.cluster.keep_only(())
            return
        self._order_frames()
        self.jobs.update(self._order.frames)
        self._update_progress()
        self._exchange_with_cluster()
        self._read_ahead()

    def _order_frames(self) -> None:
        """Sort the frames into rendering order; during playback, keep the order while it applies.

        It applies as long as the played frames and the largest number of frames stay the same.
        """
        timeline = self._timeline
        max_count = min(_MAX_FRAMES, max(1, self.store.capacity(self.picture_bytes)))
        order = PlayOrder(self._editing.frame, timeline.direction, timeline.played, max_count)
        old_order, is_playing = self._order, bool(timeline.playback.direction)
        is_kept = is_playing and (order.played, order.frames_max) == (
            old_order.played,
            old_order.frames_max,
        )
        if order != old_order and not is_kept:
            self._order = order

    @property
    def picture_bytes(self) -> int:
        """The memory that the pixels of one frame take, in bytes."""
        width, height = self.jobs.size
        return width * height * _PIXEL_BYTES

    # After each change of a drag all frames have new keys. Computing all of them takes 50 to 150 ms
    # in the demo, so keys are computed for a few milliseconds at a time while nothing else is to
    # do. The known ones are counted meanwhile, and the blue line under the ruler grows.
    def _update_progress(self) -> None:
        """Update which frames are rendered and which are not, as far as their keys are known."""
        jobs, order = self.jobs, self._order
        seconds = _KEYS_S if self._clock() >= self._rest_from_s else 0.0
        self.is_counting = not jobs.make(order.frames, seconds)
        request = FramesRequest(jobs.inputs, order, jobs.count, self.store.version)
        if request != self.progress.request:
            self.progress = progress_of(
                request, jobs.ready_jobs(order.frames), self.store.known_keys()
            )

    # A change of the shot changes the keys, so frames with the old keys are canceled at once, even
    # while the user does not rest. A new request replaces the last one, so it is sent only at rest.
    def _exchange_with_cluster(self) -> None:
        """Store frames that workers have rendered; once the user rests, request missing ones."""
        is_resting = self._clock() >= self._rest_from_s
        if self.is_counting:
            if not is_resting:
                self.cluster.keep_only(())
            return
        progress = self.progress
        for key in self.cluster.store_arrived(progress.keys):
            self._made_keys.add(key)
            self.frames_made += 1
        if is_resting:
            self.cluster.request_frames(self._untried_jobs(progress.missing_jobs), progress.request)
        else:
            self.cluster.keep_only(progress.keys)

    def _read_ahead(self) -> None:
        """Read the frames that are played next into memory."""
        timeline = self._timeline
        direction = timeline.playback.direction
        max_count = self.store.memory.limit_bytes // (2 * self.picture_bytes)
        max_count = min(_AHEAD if direction else 2, max_count)
        direction = direction or timeline.direction
        ahead = PlayOrder(self._editing.frame, direction, timeline.played, max_count)
        jobs = (self.jobs.job_of(frame) for frame in ahead.frames)
        self.store.fetch([job.key for job in jobs if job is not None])

    def note_input(self) -> None:
        """Note user input, after which rendering ahead pauses."""
        self._rest_from_s = self._clock() + _REST_S
        self._made_keys.clear()

    def seconds_until_needed(self) -> float | None:
        """Return the seconds until a frame can be rendered; None if there is none to render."""
        if not self.has_work and (
            not self.is_on or self.cluster.has_requested(self.progress.request)
        ):
            return None
        return max(0.0, self._rest_from_s - self._clock())

    @property
    def has_work(self) -> bool:
        """True if there is work for once the user rests.

        It is a frame to render, keys of frames to compute, or a cached frame to convert for the
        screen.
        """
        if self._timeline.playback.direction or self._is_busy() or not self.is_on:
            return False
        if self._next_job() is None:
            return self.is_counting or self.screen.has_work
        is_reading = self._filler is not None and self._filler.is_reading
        return not is_reading and self.store.can_take_picture

    def _next_job(self, skip_count: int = 0) -> FrameJob | None:
        """Return the next frame to render on this machine after `skip_count` others, or None."""
        return next(
            islice(
                self._untried_jobs(self.cluster.local_jobs(self.progress.missing_jobs)),
                skip_count,
                None,
            ),
            None,
        )

    def _untried_jobs(self, jobs: Iterable[FrameJob]) -> Iterator[FrameJob]:
        """Return the jobs that were neither rendered nor refused since the last user input."""
        tried_keys = self._refused_keys | self._made_keys
        return (job for job in jobs if job.key not in tried_keys)

    def work(self) -> None:
        """Continue with the next frame for one slice, if the user rests.

        Errors are not raised here; they are reported when the frame is shown.
        """
        self._update_progress()
        job = self._next_job()
        if self.is_counting:
            return
        if job is None:
            self._free_memory()
            self.screen.prepare()
        elif self.has_work and self._clock() >= self._rest_from_s:
            self._render_slice(job)

    # A frame that raises is refused until another source is opened: it would fail again in each
    # slice, and the frames after it would not be rendered. The error is reported when the frame is
    # shown, where the user can act on it.
    def _render_slice(self, job: FrameJob) -> None:
        """Render a frame for one slice, and store it once it is complete."""
        try:
            with report_faults("A frame could not be rendered ahead"):
                picture = self._prepare_filler().work(job, self._next_job(1), _SLICE_S)
        except HeatlensError:
            self._refused_keys.add(job.key)
            return
        if picture is not None:
            self._made_keys.add(job.key)
            self.store.put(job.key, picture)
            self.frames_made += 1

    def _prepare_filler(self) -> FrameFiller:
        """Return the filler, loaded with the scene if one is open."""
        main_renderer = self._source.picture.renderer
        if self._filler is None:
            self._filler = FrameFiller(main_renderer.make_sibling(), self._wake)
        if main_renderer.scene is not self._filler.renderer.scene:
            self._filler.unload()
            if main_renderer.has_many_views:
                self._filler.renderer.load_scene_of(main_renderer)
        return self._filler

    def _free_memory(self) -> None:
        """Free the GPU memory while there is nothing to render."""
        if self._filler is not None:
            self._filler.unload()

    def restart(self) -> None:
        """Forget all frames, made or refused, because another source was opened."""
        self._free_memory()
        self._refused_keys.clear()
        self._made_keys.clear()
        self.cluster.forget_failures()
        self.screen.forget_frames()

    # Commands

    def clear(self) -> None:
        """Delete all cached frames, of this shot and of all others."""
        self.store.clear()
        self.screen.forget_frames()
        self._made_keys.clear()
        self._refused_keys.clear()

    @property
    def preferences(self) -> PreferenceValues:
        """The preferences, which have the limits of cached frames."""
        return self._preferences.values

    def switch(self) -> None:
        """Switch rendering ahead on or off, in the user's preferences."""
        self._preferences.change(keep_frames=not self._preferences.values.keep_frames)

    def resize(self, memory_mb: int, disk_mb: int) -> None:
        """Set the limits for cached frames in MB."""
        self._preferences.change(memory_mb=memory_mb, disk_mb=disk_mb)
        self.store.resize(memory_bytes_of(memory_mb), disk_mb * MEGABYTE)

    def close(self) -> None:
        """Leave the cluster, finish writing the cached frames and end the threads."""
        if self._filler is not None:
            self._filler.close()
        self.cluster.close()
        self.jobs.close()
        self.store.close()
