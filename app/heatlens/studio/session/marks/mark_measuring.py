"""Measure the marks of the open shot: their distances, and the focus with which they are sharp.

Picking the thing at a pixel and reading frames to follow one happen on a thread. The distances of
a scene's marks over its frames are measured a few at a time while idle.
"""

import time
from collections.abc import Callable, Collection
from dataclasses import replace
from itertools import count
from math import inf

from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.messages import Worker
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.live_focus import Distances
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.marks.marks import (
    MatteMark,
    ObjectMark,
    PointMark,
    distance_at_m,
)
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.mattes.mattes import thing_at
from heatlens.media.plate.plate import Plate
from heatlens.studio.session.scenes.scene_commands import SceneCommands
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.time.focus_track import MarkTrack, mark_track
from heatlens.studio.session.time.timeline import Timeline


def mark_on_object(plate: Plate, point: PointMark) -> PointMark | MatteMark:
    """Return a mark on the thing under a point; the point itself where there is none."""
    thing = thing_at(plate, int(point.x_px), int(point.y_px))
    return point if thing is None else MatteMark(point.name, thing)


def named_after_thing(mark: MatteMark, used_names: Collection[str]) -> MatteMark:
    """Return the mark with the name of its thing, such as "hero", or "hero 2" if that is used.

    A thing that has only a number or a channel keeps the letter.
    """
    source, _, thing = mark.matte.partition(":")
    name = thing.rpartition("/")[2].strip()
    if source == "matte" or name.isdigit() or not name or not name.isprintable():
        return mark
    names = (f"{name} {number}" if number > 1 else name for number in count(1))
    return replace(mark, name=next(it for it in names if it not in used_names))


def smooth_distances(mark: Mark, distances_m: Distances, frames: FrameRange) -> Distances:
    """Return the distances with as many frames averaged as the mark asks for."""
    if not isinstance(mark, PointMark) or mark.smooth_frames == 1:
        return distances_m

    def depth_at(frame: int, x: float, y: float) -> float:
        return distances_m[frame] or inf

    return {frame: distance_at_m(mark, frame, depth_at, frames) for frame in frames}


_SLICE_S = 0.02
_PAUSE_S = 0.005  # pause between slices, in which the window handles input
_FRAMES_MOST = 240  # largest number of measured frames per mark
_MovingMark = PointMark | ObjectMark
_DioptresByFrame = dict[int, float | None]  # dioptres by frame; None without a distance


class SceneMarkTracks(Commands, Worker):
    """The distances of a scene's marks, kept while scene and camera stay the same."""

    def __init__(
        self, shared: Shared, timeline: Timeline, scenes: SceneCommands, is_busy: Callable[[], bool]
    ) -> None:
        """Create it; `is_busy` returns True while more urgent work waits."""
        super().__init__(shared)
        self._timeline, self._scenes, self._is_busy = timeline, scenes, is_busy
        self._current_view_key: object = None
        self._measured: dict[object, _DioptresByFrame] = {}
        self._is_requested = False  # whether `tracks` was called since the last `poll`

    def tracks(self) -> tuple[MarkTrack, ...]:
        """Return the known parts of the tracks of all moving marks, and request the rest."""
        self._is_requested = True
        self._forget_old_view()
        return tuple(self._track(mark) for mark in self._marks)

    @property
    def is_due(self) -> bool:
        """True if a requested distance is unknown and there is time to measure."""
        return self._is_requested and self._is_idle and self._next_to_measure() is not None

    def poll(self) -> None:
        """Measure for a moment if tracks were requested; call this once a frame."""
        self._forget_old_view()
        end = time.perf_counter() + _SLICE_S
        while self.is_due and time.perf_counter() < end:
            self._measure_next()
        self._is_requested = False

    def seconds_until_needed(self) -> float | None:
        """Return the pause before the next slice; None if there is nothing to measure."""
        return _PAUSE_S if self.is_due else None

    @property
    def _marks(self) -> list[_MovingMark]:
        return [mark for mark in self._editing.shot.marks if isinstance(mark, _MovingMark)]

    @property
    def _frames(self) -> tuple[int, ...]:
        """The frames to measure: all, or evenly spaced ones and the last if there are too many."""
        frames = self._timeline.frames or FrameRange(0, 0)
        step = -(-frames.count // _FRAMES_MOST)
        return (*range(frames.first, frames.last, step), frames.last)

    @property
    def _is_idle(self) -> bool:
        """True if nothing moves or plays, and no more urgent work waits."""
        is_moving = self._timeline.playback.direction or self._editing.is_unsettled
        is_settled = self._source.is_settled_at(self._editing.frame)
        return is_settled and not (is_moving or self._is_busy())

    def _forget_old_view(self) -> None:
        """Forget all distances if the scene or the view of it has changed."""
        view_key = (self._scenes.scene, *_view_key(self._editing.shot))
        if view_key != self._current_view_key:
            self._current_view_key, self._measured = view_key, {}

    def _measured_of(self, mark: _MovingMark) -> _DioptresByFrame:
        """Return the distances of a mark that are measured so far, to read and to add to."""
        return self._measured.setdefault(_position_key(mark), {})

    def _next_to_measure(self) -> tuple[_MovingMark, int] | None:
        """Return the next mark and frame to measure, all marks progressing equally; or None."""
        frames = self._frames
        missing = [
            (len(measured), mark)
            for mark in self._marks
            if len(measured := self._measured_of(mark)) < len(frames)
        ]
        if not missing:
            return None
        mark = min(missing, key=lambda pair: pair[0])[1]
        measured = self._measured_of(mark)
        return mark, next(frame for frame in frames if frame not in measured)

    def _measure_next(self) -> None:
        """Measure the next mark at the next frame, if there is one."""
        mark_and_frame = self._next_to_measure()
        if mark_and_frame is not None:
            mark, frame = mark_and_frame
            self._measured_of(mark)[frame] = self._measure_dioptres(mark, frame)

    def _measure_dioptres(self, mark: _MovingMark, frame: int) -> float | None:
        """Return the distance of a mark at a frame in dioptres; None if it has none."""
        try:
            if isinstance(mark, ObjectMark):
                distance_m = self._scenes.object_m(mark.object_name, frame)
            else:
                distance_m = self._scenes.point_m(int(mark.x_px), int(mark.y_px), frame)
        except HeatlensError:  # outside the picture, or an impossible lens at this frame
            return None
        return None if distance_m is None else 1.0 / distance_m

    def _track(self, mark: _MovingMark) -> MarkTrack:
        """Return the track of a mark, with gaps at frames without a distance."""
        measured = self._measured_of(mark)
        samples = [(frame, measured[frame]) for frame in self._frames if frame in measured]
        return mark_track(mark.name, [samples])


def _view_key(shot: Shot) -> tuple[object, ...]:
    """Return a key of everything that decides the view of the scene, independent of the focus."""
    lens = shot.lens
    focal_length = shot.curves.of(LensParameter.FOCAL_LENGTH)
    return shot.framing, lens.focal_length_mm, lens.sensor_width_mm, focal_length


def _position_key(mark: _MovingMark) -> object:
    """Return a key that is equal for marks at the same position."""
    if isinstance(mark, ObjectMark):
        return mark.object_name
    return int(mark.x_px), int(mark.y_px)
