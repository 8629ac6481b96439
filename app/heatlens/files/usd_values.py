"""Check the types of values in a USD file, whose attributes may hold anything."""

import math

import numpy as np
from numpy.typing import NDArray

from heatlens.base.errors import InputError
from heatlens.files.usd_library import UsdObject


def numbers(value: object, width: int, what: str) -> NDArray[np.float32]:
    """Return an array of numbers or of tuples as (N, width) float32; None gives (0, width).

    Raises InputError that begins with `what` for anything else. Numbers too large for float32
    become infinite.
    """
    with np.errstate(over="ignore"):
        return _array(value, width, what).astype(np.float32)


def whole_numbers(value: object, what: str) -> NDArray[np.int64]:
    """Return an array of integers as (N,) int64. Raises InputError as `numbers` does."""
    found = _array(value, 1, what)[:, 0]
    if found.dtype.kind not in "iu" and found.size:
        raise _refusal(value, what)
    return found.astype(np.int64)


def number(value: object, what: str) -> float:
    """Return a number that is not NaN. Raises InputError as `numbers` does."""
    if isinstance(value, float | int) and not math.isnan(value):
        return float(value)
    raise _refusal(value, what)


def _array(value: object, width: int, what: str) -> NDArray[UsdObject]:
    try:
        found = np.array([] if value is None else value)
        if found.dtype.kind in "biuf":
            return found.reshape(-1, width)
    except (TypeError, ValueError, OverflowError, RuntimeError) as error:
        raise _refusal(value, what) from error
    raise _refusal(value, what)


def _refusal(value: UsdObject, what: str) -> InputError:
    said = " ".join(str(value).split())[:60]
    return InputError(f"{what} is not a number, or has the wrong count: {said!r}.")
