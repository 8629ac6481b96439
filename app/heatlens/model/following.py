"""Turn the distances of an object over the frames into a focus with few keys that follows it.

The steps are those of an assistant's hand: it bridges what is hidden, ignores small moves, is late
or early, moves gently, and is no faster than the ring turns.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean

import numpy as np

from heatlens.base.errors import InputError
from heatlens.model.coc import sharp_dioptres
from heatlens.model.interpolation import Scale
from heatlens.model.option import option_field, options_of
from heatlens.model.pull import performed
from heatlens.model.shot import Shot

_REDUCED = 0.125  # largest error of the keys, as a share of the sharp range
Distances = Mapping[int, float | None]  # metres by frame; None where the thing is hidden


@dataclass(frozen=True, slots=True)
class Follow:
    """How the focus follows an object. Raises InputError for a number outside its range."""

    ignored_part: float = option_field(
        0.125,
        "follow ignores",
        "ignore movements smaller than this share of the sharp range, 0 to 0.5 (default 0.125); "
        "reducing the curve to few keys may add as much error again",
        metavar="PART",
        least=0,
        most=0.5,
    )
    late_frames: int = option_field(
        0,
        "follow late",
        "frames by which the focus is late, like that of a person; negative: early (default 0)",
        metavar="FRAMES",
        least=-1000,
        most=1000,
    )
    ease_frames: int = option_field(
        0,
        "follow ease",
        "frames averaged before and after each frame, so that the focus starts and stops gently "
        "(default 0)",
        metavar="FRAMES",
        least=0,
        most=1000,
    )
    most_dioptres_per_s: float = option_field(
        0.0,
        "follow speed",
        "highest speed of the focus, in dioptres per second (default: no limit)",
        metavar="DIOPTRES",
        least=0,
        most=1000,
    )

    def __post_init__(self) -> None:
        for name, told in options_of(Follow).items():
            if not told.allows(value := getattr(self, name)):
                span = f"{told.least:g} to {told.most:g}"
                raise InputError(f"--{told.flag} must be {span}, got {value:g}.")


def followed(shot: Shot, distances_m: Distances, follow: Follow | None = None) -> Shot:
    """Return the shot with the focus on a thing at all frames of `distances_m`.

    Its keys replace all keys in their range. With the default `follow` the focus is off by no more
    than a quarter of the sharp range. Raises InputError if the thing is hidden at every frame,
    LensError if it comes nearer than a lens can be focused.
    """
    follow, frames = follow or Follow(), sorted(distances_m)
    seen = [far_m for far_m in distances_m.values() if far_m is not None]
    if not seen:
        raise InputError("It is hidden, or out of the picture, at every frame.")
    sharp = [sharp_dioptres(shot.lens_at(frame)) for frame in frames]
    track = bridged([distances_m[frame] for frame in frames])
    track = _settled(track, [2.0 * follow.ignored_part * part for part in sharp])
    track = _eased(_late(track, follow.late_frames), follow.ease_frames)
    track = _limited(track, follow.most_dioptres_per_s / shot.frames_per_second)
    samples = [(f, Scale.RECIPROCAL.value_at(at)) for f, at in zip(frames, track, strict=True)]
    return performed(shot, samples, 2.0 * _REDUCED * min(sharp))


def bridged(distances_m: Sequence[float | None]) -> list[float]:
    """Return the dioptres of distances, at least one of which is known.

    Gaps are bridged by a straight line; before the first and after the last distance they are held.
    """
    known = [at for at, far_m in enumerate(distances_m) if far_m is not None]
    places = [1.0 / far_m for far_m in distances_m if far_m is not None]
    return [float(place) for place in np.interp(range(len(distances_m)), known, places)]


def _settled(track: list[float], slack: list[float]) -> list[float]:
    """Return the track with moves ignored that are smaller than the slack at each frame."""
    at, settled = track[0], []
    for place, reach in zip(track, slack, strict=True):
        at = min(max(at, place - reach), place + reach)
        settled.append(at)
    return settled


def _late(track: list[float], frames: int) -> list[float]:
    last = len(track) - 1
    return [track[min(max(at - frames, 0), last)] for at in range(len(track))]


def _eased(track: list[float], reach: int) -> list[float]:
    """Return the running mean over equally many frames before and after."""
    eased = []
    for at in range(len(track)):
        near = min(reach, at, len(track) - 1 - at)
        eased.append(fmean(track[at - near : at + near + 1]))
    return eased


def _limited(track: list[float], step_most: float) -> list[float]:
    """Return the track with no step larger than `step_most`; 0 for no limit."""
    at, limited = track[0], []
    for place in track if step_most else ():
        at += min(max(place - at, -step_most), step_most)
        limited.append(at)
    return limited or track
