"""Parse single values of lens metadata: distances, irises and squeezes as cameras write them."""

import math
import re
from dataclasses import dataclass

from heatlens.base.errors import InputError
from heatlens.model.units import is_bare_number, parse_distance_m, with_points

_MISSING = ("", "-", "--", "n.a.", "n/a", "na", "nan", "none", "null", "unknown", "invalid")
_NUMBER = r"[0-9]+(?:\.[0-9]+)?"
_STOP_AND_TENTHS = re.compile(rf"[tf]?/?\s*({_NUMBER})\s*\+\s*([0-9])/10")  # 1.4 + 7/10
_STOPS_FROM_ONE = re.compile(r"[tf]\s+([0-9]{1,2})(?:\s+([0-9])/10)?")  # T 2 3/10
_MILLIMETRE_M = 1e-3
_LEAST, _MOST = 1e-6, 1e6  # in whatever unit; no lens has a length or a focus beyond them


@dataclass(frozen=True)
class Length:
    """A length above zero as it was written; `unit_m` is None for a number without a unit.

    `value` counts metres where `unit_m` is not None, and unknown units otherwise.
    """

    value: float
    unit_m: float | None

    def in_metres(self, bare_m: float) -> float:
        """Return metres; a number without a unit counts units of `bare_m` metres."""
        return self.value * (bare_m if self.unit_m is None else 1.0)

    def in_millimetres(self, bare_m: float | None) -> float:
        """Return millimetres, which a number without a unit counts where `bare_m` is None."""
        if self.unit_m is None and bare_m in (None, _MILLIMETRE_M):
            return self.value
        return self.in_metres(bare_m or 1.0) / _MILLIMETRE_M


def is_missing(value: object) -> bool:
    """Return True for an empty value, a word for a missing one, NaN, and zero."""
    if isinstance(value, int | float):
        return isinstance(value, bool) or value == 0 or math.isnan(value)
    text = str(value).strip().lower()
    return text in _MISSING or _number(text) == 0


def distance(value: object) -> Length | None:
    """Return a distance, which may be infinite but not zero; None if it cannot be read."""
    if isinstance(value, int | float):
        return Length(float(value), None) if value >= _LEAST else None
    text = str(value)
    try:
        distance_m = parse_distance_m(text)
    except InputError:
        return None
    if distance_m < _LEAST:
        return None
    return Length(distance_m, None if is_bare_number(text) else 1.0)


def focal_length(value: object) -> Length | None:
    """Return a finite length above zero; None if it cannot be read."""
    length = distance(value)
    return None if length is None or length.value > _MOST else length


def squeeze(value: object) -> float | None:
    """Return the squeeze of an anamorphic lens, 1 to 2, as in 1.8 or "2x"; None for others."""
    number = _number(str(value).strip().lower().removesuffix("x"))
    return number if number is not None and 1.0 <= number <= 2.0 else None


def linear_iris(value: object) -> float | None:
    """Return the T-number of thousandths of a stop, of which 1000 are T1; None for others."""
    thousandths = _number(value)
    if thousandths is None or not 0 < thousandths < 20_000:
        return None
    return float(2.0 ** ((thousandths - 1000.0) / 2000.0))


def stop(value: object) -> float | None:
    """Return the f- or T-number of a number, "T2.8", ARRI's "1.4 + 7/10" or Sony's "T 2 3/10".

    None for any other text, and for impossible numbers.
    """
    text = with_points(str(value).strip().lower())
    number: float | None = None
    if match := _STOP_AND_TENTHS.fullmatch(text):
        number = float(match[1]) * 2.0 ** (int(match[2]) / 20.0)
    elif match := _STOPS_FROM_ONE.fullmatch(text):
        number = float(2.0 ** ((int(match[1]) + int(match[2] or 0) / 10.0) / 2.0))
    else:
        number = _number(text.removeprefix("t").removeprefix("f").removeprefix("/"))
    return number if number is not None and 0.3 <= number <= 128.0 else None


def _number(value: object) -> float | None:
    """Return a finite number; None for anything else."""
    text = with_points(str(value).strip().lower())
    if not is_bare_number(text):
        return None
    number = float(text)
    return number if math.isfinite(number) else None
