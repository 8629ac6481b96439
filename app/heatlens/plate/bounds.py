"""Limits on how near, how blurred and how bright the pixels of a plate may be.

A damaged file, a wrong unit or a program's marker for "nothing here" gives values that no camera
records. Beyond these limits, sums over a picture would overflow. Values are clamped when a plate
is read, and one note tells the user.
"""

import numpy as np

from heatlens.model.focus.coc import COC_MOST_PX
from heatlens.plate.plate import FloatImage

# A thousandth of a millimetre in front of the lens. Anything nearer is treated as a missing depth
# and repaired: its blur would overflow on a GPU.
DEPTH_LEAST_M = 1e-6
# The sum over all pixels of the largest plate, and its square, stay below float32's 3.4e38.
LIGHT_MOST = 1e14


def bound_coc(coc_px: FloatImage, what: str) -> tuple[str, ...]:
    """Clamp diameters (H, W) of the circle of confusion in place, and return notes about it.

    The notes are empty if nothing had to be clamped. `what` names the file and the channel.
    """
    count = int(np.count_nonzero(np.abs(coc_px) > COC_MOST_PX))
    np.clip(coc_px, -COC_MOST_PX, COC_MOST_PX, out=coc_px)
    words = f"a circle of confusion of more than {COC_MOST_PX:,.0f} px"
    return _clamped_note(what, words, count, coc_px.size)


def bound_color(color: FloatImage, what: str) -> tuple[str, ...]:
    """Clamp finite colours (H, W, C) in place, and return notes, as `bound_coc` does."""
    if -LIGHT_MOST <= color.min() and color.max() <= LIGHT_MOST:
        return ()
    count = int(np.count_nonzero((np.abs(color) > LIGHT_MOST).any(axis=2)))
    np.clip(color, -LIGHT_MOST, LIGHT_MOST, out=color)
    words = f"light beyond {LIGHT_MOST:g}"
    return _clamped_note(what, words, count, color.shape[0] * color.shape[1])


def _clamped_note(what: str, words: str, count: int, size: int) -> tuple[str, ...]:
    if not count:
        return ()
    return (f"{what} holds {words} in {count} of {size} pixels: they were set to this limit.",)
