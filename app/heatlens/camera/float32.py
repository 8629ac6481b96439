"""Numbers that a file keeps in float32, read as the short decimals that were meant."""

import numpy as np

_DIGITS_MOST = 9  # that many tell any two float32 apart


def shortest(stored: float, unit: float = 1.0) -> float:
    """The shortest decimal whose product with `unit` is kept as `stored`: 1.3, not 1.29999995.

    `stored` is in units of the file, the result not: both are one length.
    """
    value = stored / unit
    kept = np.float32(stored)
    for digits in range(1, _DIGITS_MOST + 1):
        short = float(f"{value:.{digits}g}")
        if np.float32(short * unit) == kept:
            return short
    return value
