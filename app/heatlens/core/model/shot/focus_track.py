"""The focus and its range of sharpness over the frames of a shot, in dioptres."""

from dataclasses import dataclass

from heatlens.core.base.errors import HeatlensError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.coc import far_limit_m, near_limit_m
from heatlens.core.model.shot.pull import frames_too_close
from heatlens.core.model.shot.shot import Shot

_MAX_CHECKED = 2000  # frames that are checked for a focus that is too close


@dataclass(frozen=True, slots=True)
class Sample:
    """One time, with the focus and the limits of the sharp range in 1/m."""

    frame: float
    focus: float
    near: float
    far: float


class FocusTrack:
    """The samples over the visible frames, recomputed when these or the shot change."""

    def __init__(self) -> None:
        self._samples_key: object = None
        self._samples: tuple[Sample, ...] = ()
        self._too_close_key: object = None
        self._too_close: tuple[int, ...] = ()

    def samples(self, shot: Shot, first: float, last: float, count: int) -> tuple[Sample, ...]:
        """Return `count` evenly spaced samples from first to last, and one at every key between."""
        key = (shot.lens, shot.curves, first, last, count)
        if key != self._samples_key:
            times = {first + (last - first) * index / (count - 1) for index in range(count)}
            times |= {frame for frame in shot.key_frames if first <= frame <= last}
            self._samples = tuple(_sample(shot, time) for time in sorted(times))
            self._samples_key = key
        return self._samples

    def too_close_frames(self, shot: Shot, frames: FrameRange) -> tuple[int, ...]:
        """Return the visible frames at which the lens cannot focus as near as it should."""
        key = (shot.lens, shot.curves, frames)
        if key != self._too_close_key:
            self._too_close, self._too_close_key = _too_close_frames(shot, frames), key
        return self._too_close


def _too_close_frames(shot: Shot, frames: FrameRange) -> tuple[int, ...]:
    """Return the frames with a focus that is too close for the lens; none of a very long shot."""
    if frames.count > _MAX_CHECKED:
        return ()
    try:
        return frames_too_close(Shot(shot.lens, curves=shot.curves, frames=frames))
    except HeatlensError:  # no valid lens at some frame; reported where that frame is shown
        return ()


def _sample(shot: Shot, time: float) -> Sample:
    """Return the focus and the sharp range at a time; all 0 if the lens is impossible there."""
    try:
        lens = shot.lens_at(time)
    except HeatlensError:  # between two keys of a long lens and a near focus
        return Sample(frame=time, focus=0.0, near=0.0, far=0.0)
    return Sample(
        time, 1.0 / lens.focus_distance_m, 1.0 / near_limit_m(lens), 1.0 / far_limit_m(lens)
    )
