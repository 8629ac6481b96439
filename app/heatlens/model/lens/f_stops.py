"""The numbers engraved on an aperture ring, in third stops."""

import math
from bisect import bisect_left, bisect_right

# Powers of 2^(1/6), rounded as makers engrave them (ISO 517 for the whole stops).
THIRD_STOPS = (
    *(0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.4, 1.6, 1.8, 2.0, 2.2, 2.5, 2.8, 3.2, 3.5, 4.0, 4.5, 5.0),
    *(5.6, 6.3, 7.1, 8.0, 9.0, 10.0, 11.0, 13.0, 14.0, 16.0, 18.0, 20.0, 22.0, 25.0, 29.0, 32.0),
)
_SAME = 1e-4  # relative, so that 2.8 stays 2.8 after rounding to float32


def stepped(f_stop: float, steps: int) -> float:
    """Return the f-stop `steps` third stops up the ring, or down if negative.

    A value between two stops of the ring counts as one step. The result stays on the ring; 0 steps
    leave the value alone.
    """
    if steps > 0:
        index = bisect_right(THIRD_STOPS, f_stop * (1 + _SAME)) + steps - 1
    elif steps < 0:
        index = bisect_left(THIRD_STOPS, f_stop * (1 - _SAME)) + steps
    else:
        return f_stop
    return THIRD_STOPS[min(max(index, 0), len(THIRD_STOPS) - 1)]


def nearest_index(f_stop: float) -> int:
    """Return the index of the nearest stop of the ring, measured in stops."""
    return min(range(len(THIRD_STOPS)), key=lambda i: abs(math.log2(THIRD_STOPS[i] / f_stop)))
