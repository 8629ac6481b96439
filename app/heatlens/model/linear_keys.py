"""The fewest keys that meet a value which is known at every frame."""

import math

from heatlens.model.curve import Key
from heatlens.model.interpolation import Interpolation, Scale

# Relative difference of a value that was rounded to float32 twice.
_SAME = 2e-7


def linear_keys(frames: tuple[int, ...], track: tuple[float, ...], scale: Scale) -> tuple[Key, ...]:
    """Return the fewest keys that meet the track at every frame; none for a constant track.

    A key is left out if it lies on the straight line between its neighbours on `scale`: the line
    from the last key to the next has to pass every frame in between within the precision of
    float32.
    """
    if len(set(track)) < 2:
        return ()
    places = [scale.place_of(value) for value in track]
    kept = [0]
    lowest, highest = -math.inf, math.inf  # slopes from the last key that pass every frame since
    for index in range(1, len(frames)):
        slope, frame_count = _slope(frames, places, kept[-1], index)
        if not lowest <= slope <= highest:
            kept.append(index - 1)
            lowest, highest = -math.inf, math.inf
            slope, frame_count = _slope(frames, places, index - 1, index)
        reach = _slack(track[index], scale) / frame_count
        lowest, highest = max(lowest, slope - reach), min(highest, slope + reach)
    kept.append(len(frames) - 1)
    return tuple(Key(frames[at], track[at], Interpolation.LINEAR) for at in kept)


def _slope(frames: tuple[int, ...], places: list[float], start: int, end: int) -> tuple[float, int]:
    count = frames[end] - frames[start]
    return (places[end] - places[start]) / count, count


def _slack(value: float, scale: Scale) -> float:
    """Return the largest difference on the scale that rounds to the same float32 value."""
    return _SAME * abs(scale.slope_at(value) * value) if math.isfinite(value) else 0.0
