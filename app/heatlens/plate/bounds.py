"""How near, how blurred and how bright a plate may be: beyond, no picture can tell, and sums end.

A damaged file, a wrong unit or a program's mark for "nothing" brings values that no camera has.
They are settled where a plate is read, and that is said once.
"""

import numpy as np

from heatlens.plate.plate import FloatImage

# A thousandth of a millimetre in front of the lens. What is nearer is no surface, and is mended as
# a missing depth is: its blur would be wider than numbers on a GPU can hold.
DEPTH_LEAST_M = 1e-6
# Sixty times the width of the largest plate.
COC_MOST_PX = 1e6
# The sum over all pixels of the largest plate, and its square, stay below float32's 3.4e38.
LIGHT_MOST = 1e14


def bound_coc(coc_px: FloatImage, what: str) -> tuple[str, ...]:
    """Bring diameters (H, W) of the circle of confusion into bounds, in place, and return notes.

    There are no notes where all were within bounds. `what` names file and channel.
    """
    count = int(np.count_nonzero(np.abs(coc_px) > COC_MOST_PX))
    np.clip(coc_px, -COC_MOST_PX, COC_MOST_PX, out=coc_px)
    words = f"a circle of confusion of more than {COC_MOST_PX:,.0f} px"
    return _said(what, words, count, coc_px.size)


def bound_color(color: FloatImage, what: str) -> tuple[str, ...]:
    """Bring finite light (H, W, C) into bounds, in place, and return notes, as `bound_coc`."""
    if -LIGHT_MOST <= color.min() and color.max() <= LIGHT_MOST:
        return ()
    count = int(np.count_nonzero((np.abs(color) > LIGHT_MOST).any(axis=2)))
    np.clip(color, -LIGHT_MOST, LIGHT_MOST, out=color)
    return _said(what, f"light beyond {LIGHT_MOST:g}", count, color.shape[0] * color.shape[1])


def _said(what: str, words: str, count: int, size: int) -> tuple[str, ...]:
    if not count:
        return ()
    return (f"{what} holds {words} in {count} of {size} pixels: they were set to that.",)
