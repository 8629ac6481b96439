"""How far marks of a scene are over its frames: drawn a few at a time while nothing moves."""

import time
from collections.abc import Callable
from itertools import groupby

from heatlens.errors import HeatlensError
from heatlens.model.frames import FrameRange
from heatlens.model.marks import DistanceMark, ObjectMark, PointMark
from heatlens.model.shot import LensParameter, Shot
from heatlens.session.editing import Editing
from heatlens.session.focus_track import MarkTrack
from heatlens.session.open_source import OpenSource
from heatlens.session.scene_commands import SceneCommands
from heatlens.session.timeline import Timeline

_SLICE_S = 0.02
_FRAMES_MOST = 240  # that a mark is measured at; a line between two of them is straight
_Moving = PointMark | ObjectMark
_Known = dict[int, float | None]  # dioptres by frame, None where there is no distance


class SceneMarkTracks:
    """How far marks of a scene are, kept while scene, camera and angle are the same."""

    def __init__(
        self,
        source: OpenSource,
        editing: Editing,
        timeline: Timeline,
        scenes: SceneCommands,
        is_busy: Callable[[], bool],
    ) -> None:
        """Take `is_busy`, which returns whether other work, as the visible picture, comes first."""
        self._source = source
        self._editing = editing
        self._timeline = timeline
        self._scenes = scenes
        self._is_busy = is_busy
        self._seen_by: object = None
        self._known: dict[object, _Known] = {}
        self._is_asked = False  # since the last `poll`

    def tracks(self) -> tuple[MarkTrack, ...]:
        """Return the tracks of all marks that move, as far as they are known; ask for the rest."""
        self._is_asked = True
        self._forget_what_changed()
        return tuple(self._track(mark) for mark in self._marks)

    @property
    def is_due(self) -> bool:
        """Return True where something was asked for that is not known, and there is time for it."""
        return self._is_asked and self._is_idle and self._next() is not None

    def poll(self) -> None:
        """Measure for a moment, if that was asked for; call this once a frame."""
        self._forget_what_changed()
        end = time.perf_counter() + _SLICE_S
        while self.is_due and time.perf_counter() < end:
            self._measure()
        self._is_asked = False

    @property
    def _marks(self) -> list[_Moving]:
        return [mark for mark in self._editing.shot.marks if not isinstance(mark, DistanceMark)]

    @property
    def _frames(self) -> tuple[int, ...]:
        """The frames of the shot, evenly where there are too many, and the last one."""
        frames = self._timeline.frames or FrameRange(0, 0)
        step = -(-frames.count // _FRAMES_MOST)
        return (*range(frames.first, frames.last, step), frames.last)

    @property
    def _is_idle(self) -> bool:
        is_moving = self._timeline.playback.direction or self._editing.is_unsettled
        is_settled = self._source.is_settled_at(self._editing.frame)
        return is_settled and not (is_moving or self._is_busy())

    def _forget_what_changed(self) -> None:
        seen_by = (self._scenes.scene, *_looked_at(self._editing.shot))
        if seen_by != self._seen_by:
            self._seen_by, self._known = seen_by, {}

    def _known_of(self, mark: _Moving) -> _Known:
        return self._known.setdefault(_place(mark), {})

    def _next(self) -> tuple[_Moving, int] | None:
        """Return a mark and a frame at which it is not known yet; all marks grow alike."""
        frames = self._frames
        missing = [
            (len(known), mark)
            for mark in self._marks
            if len(known := self._known_of(mark)) < len(frames)
        ]
        if not missing:
            return None
        mark = min(missing, key=lambda pair: pair[0])[1]
        known = self._known_of(mark)
        return mark, next(frame for frame in frames if frame not in known)

    def _measure(self) -> None:
        found = self._next()
        if found is not None:
            mark, frame = found
            self._known_of(mark)[frame] = self._dioptres(mark, frame)

    def _dioptres(self, mark: _Moving, frame: int) -> float | None:
        try:
            if isinstance(mark, ObjectMark):
                distance_m = self._scenes.object_m(mark.object_name, frame)
            else:
                distance_m = self._scenes.point_m(int(mark.x_px), int(mark.y_px), frame)
        except HeatlensError:  # beside the picture, or no lens at this frame
            return None
        return None if distance_m is None else 1.0 / distance_m

    def _track(self, mark: _Moving) -> MarkTrack:
        """Return the line of a mark, with gaps where it has no distance."""
        known = self._known_of(mark)
        places = [(frame, known[frame]) for frame in self._frames if frame in known]
        parts = groupby(places, key=lambda place: place[1] is None)
        return MarkTrack(
            mark.name,
            tuple(
                tuple((frame, place) for frame, place in part if place is not None)
                for is_gap, part in parts
                if not is_gap
            ),
        )


def _looked_at(shot: Shot) -> tuple[object, ...]:
    """Return a key that is equal where a scene is seen alike at every frame, whatever the focus."""
    lens = shot.lens
    focal_length = shot.curves.of(LensParameter.FOCAL_LENGTH)
    return shot.framing, lens.focal_length_mm, lens.sensor_width_mm, focal_length


def _place(mark: _Moving) -> object:
    """Return a key that is equal for marks that are equally far."""
    if isinstance(mark, ObjectMark):
        return mark.object_name
    return int(mark.x_px), int(mark.y_px)
