"""Read numbers that a file keeps in float32 as the short decimals that were meant."""

import numpy as np

_DIGITS_MOST = 9  # enough digits to distinguish any two float32


def shortest(stored: float, unit: float = 1.0) -> float:
    """Return the shortest decimal that becomes `stored` in float32: 1.3, not 1.29999995.

    `stored` is in the unit of the file. The result times `unit` is the same length in that unit.
    """
    value = stored / unit
    kept = np.float32(stored)
    for digits in range(1, _DIGITS_MOST + 1):
        short = float(f"{value:.{digits}g}")
        if np.float32(short * unit) == kept:
            return short
    return value
