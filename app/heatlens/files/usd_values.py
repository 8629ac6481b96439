"""Values of a USD file, checked: an attribute may hold anything under any name."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatlens.errors import InputError


def numbers(value: Any, width: int, what: str) -> NDArray[np.float32]:
    """Return (N, width) of an array of numbers or of tuples; (0, width) of None.

    Raises InputError, which begins with `what`, for anything else. Numbers too large for float32
    become infinite.
    """
    with np.errstate(over="ignore"):
        return _array(value, width, what).astype(np.float32)


def whole_numbers(value: Any, what: str) -> NDArray[np.int64]:
    """Return (N,) of an array of whole numbers. Raises InputError as `numbers` does."""
    found = _array(value, 1, what)[:, 0]
    if found.dtype.kind not in "iu" and found.size:
        raise _refusal(value, what)
    return found.astype(np.int64)


def number(value: Any, what: str) -> float:
    """Return a number that is not NaN. Raises InputError as `numbers` does."""
    if isinstance(value, float | int) and not math.isnan(value):
        return float(value)
    raise _refusal(value, what)


def _array(value: Any, width: int, what: str) -> NDArray[Any]:
    try:
        found = np.array([] if value is None else value)
        if found.dtype.kind in "biuf":
            return found.reshape(-1, width)
    except (TypeError, ValueError, OverflowError, RuntimeError) as error:
        raise _refusal(value, what) from error
    raise _refusal(value, what)


def _refusal(value: Any, what: str) -> InputError:
    said = " ".join(str(value).split())[:60]
    return InputError(f"{what} is no number, or not as many as there should be: {said!r}.")
