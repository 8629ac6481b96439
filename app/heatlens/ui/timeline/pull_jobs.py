"""What has to be rendered for each frame of the shot in hand, and by which key it is kept."""

import math
import os
import time
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from heatlens.defocus.plate_passes import proxy_size
from heatlens.errors import HeatlensError, InputError
from heatlens.frame_cache.cache import FrameCache
from heatlens.model.framing import Framing
from heatlens.model.settings import PROXY_MIN
from heatlens.model.shot import Shot
from heatlens.model.view_geometry import fit_zoom
from heatlens.rendered_frames.frame_filler import FrameJob, PlateFile
from heatlens.rendered_frames.frame_key import SceneSight, Source, frame_key, maker_of, shot_key
from heatlens.rendered_frames.stamp_book import StampBook

if TYPE_CHECKING:
    from heatlens.ui.app import App

_SIZES = 16  # a picture has so many sixteenths of its size: a window a little larger changes none
_EVERY_S = 2.0  # between two looks at the files


class PullJobs:
    """The job of each frame, made when it is asked for, until shot or files or size change."""

    def __init__(
        self,
        app: "App",
        wake: Callable[[], None],
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        self._app = app
        self._clock = clock
        self._stamps = StampBook(wake)
        self._made_of: object = None
        self._jobs: dict[int, FrameJob | None] = {}
        self._shot, self._shot_key = app.shot, ""
        self._maker: tuple[str, ...] = ()
        self._look_at = -math.inf
        self.version = 0  # counts whenever jobs came or went

    @property
    def _cache(self) -> FrameCache | None:
        opened = self._app.source.opened
        return None if opened is None else opened.cache

    def update(self, frames: Iterable[int]) -> None:
        """Forget the jobs of what has changed since; `frames` are those that will be asked for."""
        if self._cache is not None and self._clock() >= self._look_at:
            self._look_at = self._clock() + _EVERY_S
            self._stamps.look({path for frame in frames if (path := self._path(frame))})
        app, shot = self._app, self._app.shot
        made_of = (
            *(app.source.opened, app.source.scene, self._stamps.version, app.timeline.missing),
            *(shot.lens, shot.curves, shot.defocus, shot.framing, self._scale),
        )
        if made_of != self._made_of:
            self._made_of, self._jobs = made_of, {}
            self._begin(shot)
            self.version += 1

    def _begin(self, shot: Shot) -> None:
        """What all frames have in common."""
        self._maker = self._maker or maker_of(self._app.renderer)
        opened = self._app.source.opened
        self._shot = self._sized(shot)
        options = shot.plate_options if opened is None else opened.options
        self._shot_key = shot_key(self._maker, options, self._shot.defocus)

    @property
    def _scale(self) -> float:
        """How large pictures are kept: about as large as the whole of one is seen."""
        app = self._app
        zoom = fit_zoom(app.viewport.viewport, app.picture_shape)
        return min(max(math.ceil(zoom * _SIZES - 0.25), 1), _SIZES) / _SIZES

    def _sized(self, shot: Shot) -> Shot:
        """Of a plate by the proxy; a scene is drawn smaller."""
        if self._app.source.scene is None:
            proxy = max(PROXY_MIN, shot.defocus.proxy * self._scale)
            return replace(shot, defocus=replace(shot.defocus, proxy=proxy))
        framing = shot.framing or Framing()
        width, height = (max(1, round(side * self._scale)) for side in framing.size)
        return replace(shot, framing=replace(framing, width_px=width, height_px=height))

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the pictures in pixels."""
        source = self._app.source
        if source.scene is not None:
            full = (self._shot.framing or Framing()).size
        elif source.plate is not None:
            window = source.plate.data_window
            full = window.width, window.height
        else:
            return 1, 1
        return proxy_size(full, self._shot.defocus.proxy)

    def make(self, frames: Iterable[int], seconds: float) -> None:
        """Make the jobs of these frames, as many as there is time for."""
        end = self._clock() + seconds
        for frame in frames:
            if frame not in self._jobs:
                try:
                    self._jobs[frame] = self._made(frame)
                except _NotYetError:
                    continue
                self.version += 1
                if self._clock() > end:
                    return

    def of(self, frame: int) -> FrameJob | None:
        """The job of a frame; None where there is nothing to render, or nothing is known yet."""
        if frame not in self._jobs:
            self.make((frame,), 1.0)
        return self._jobs.get(frame)

    def _made(self, frame: int) -> FrameJob | None:
        try:
            lens = self._shot.lens_at(frame)
            if self._app.source.scene is not None:
                key = frame_key(self._shot_key, self._scene, lens, self._sight(frame))
                return FrameJob(key, self._shot, frame, None)
            file = self._plate_file(frame)
        except HeatlensError:
            return None  # no lens, or no file: what is said of it is said where it is seen
        if file is None:
            return None
        source = Source(os.path.abspath(file.path), (file.stamp,))
        return FrameJob(frame_key(self._shot_key, source, lens), self._shot, frame, file)

    def _plate_file(self, frame: int) -> PlateFile | None:
        path, opened = self._path(frame), self._app.source.opened
        if path is None or opened is None:
            return None
        if not self._stamps.knows(path):
            raise _NotYetError
        return PlateFile(path, self._stamps.stamp(path), opened.settled)

    def _path(self, frame: int) -> Path | None:
        """The file that is shown for a frame; None for none."""
        try:
            cache, missing = self._cache, self._app.timeline.missing
            return None if cache is None else cache.sequence.resolve(frame, missing)
        except InputError:
            return None

    @property
    def _scene(self) -> Source:
        opened = self._app.source.scene
        assert opened is not None
        return Source(opened.text, opened.stamps)

    def _sight(self, frame: int) -> SceneSight | None:
        renderer, size = self._app.renderer, (self._shot.framing or Framing()).size
        pose = renderer.pose_at(self._shot, frame)
        if pose is None or renderer.scene is None:
            return None
        return SceneSight(pose, float(frame) if renderer.scene.motion else None, size)

    def close(self) -> None:
        """Look at no files any more."""
        self._stamps.close()


class _NotYetError(Exception):
    """The file of a frame has not been looked at."""
