"""Turn the distances of an object over the frames into a focus with few keys that follows it."""

from dataclasses import replace

from heatlens.base.errors import InputError
from heatlens.model.interpolation import Scale
from heatlens.model.live_focus import Distances, Follow, LiveFocus, MeasuredMark, Pursuit
from heatlens.model.pull import performed
from heatlens.model.shot import Shot, live_sharp_dioptres

_REDUCED = 0.125  # largest error of the keys, as a share of the sharp range
_NAME = "it"


def followed(shot: Shot, distances_m: Distances, follow: Follow | None = None) -> Shot:
    """Return the shot with the focus on a thing at all frames of `distances_m`.

    Its keys replace all keys in their range. With the default `follow` the focus is off by no more
    than a quarter of the sharp range. Raises InputError if the thing is hidden at every frame,
    LensError if it comes nearer than a lens can be focused.
    """
    frames = sorted(distances_m)
    if not any(far_m is not None for far_m in distances_m.values()):
        raise InputError("It is hidden, or out of the picture, at every frame.")
    measured = MeasuredMark(_NAME, tuple(distances_m[frame] for frame in frames))
    return _keyed(shot, LiveFocus((Pursuit(_NAME),), follow or Follow(), frames[0], (measured,)))


def baked(shot: Shot) -> Shot:
    """Return a shot with keys in place of the focus that follows; without one, unchanged."""
    live = shot.curves.live
    if live is None:
        return shot
    still = replace(shot, curves=replace(shot.curves, live=None))
    return _keyed(still, live) if live.measured else still


def _keyed(shot: Shot, live: LiveFocus) -> Shot:
    sharp = live_sharp_dioptres(shot, live.frames)
    track = live.dioptres(sharp, shot.frames_per_second)
    samples = [(f, Scale.RECIPROCAL.value_at(at)) for f, at in zip(live.frames, track, strict=True)]
    return performed(shot, samples, 2.0 * _REDUCED * min(sharp))
