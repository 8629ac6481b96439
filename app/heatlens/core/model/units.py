"""Distances as people write them, to and from meters."""

import math
import re

from heatlens.core.base.errors import InputError

# Exact by definition: the international yard and pound agreement of 1959.
INCH_M = 0.0254
FOOT_M = 0.3048

_UNIT_WORDS = {
    1e-3: ("mm", "millimetre", "millimetres", "millimeter", "millimeters"),
    1e-2: ("cm", "centimetre", "centimetres", "centimeter", "centimeters"),
    1.0: ("m", "metre", "metres", "meter", "meters"),
    1e3: ("km", "kilometre", "kilometres", "kilometer", "kilometers"),
    INCH_M: ("in", "inch", "inches", '"', "″", "”", "''"),
    FOOT_M: ("ft", "foot", "feet", "'", "′", "’"),
}
_UNIT_M = {word: metres for metres, words in _UNIT_WORDS.items() for word in words}
_INFINITY = {"inf", "infinity", "∞"}

_NUMBER = r"((?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:e[+-]?[0-9]+)?)"
_ONE_UNIT = re.compile(rf"{_NUMBER}\s*([a-z\"″”'′’]*)")
# The mark of the inches may be left out, as in 6'3.
_FEET_AND_INCHES = re.compile(
    rf"{_NUMBER}\s*(?:ft|feet|foot|'|′|’)\s*{_NUMBER}\s*(?:in|inch|inches|\"|″|”|'')?"
)
_SIGNIFICANT_DIGITS = 4  # lenses and tape measures are marked no finer
_CENTIMETRES_UNDER_M, _LABEL_CENTIMETRES_UNDER_M = 0.1, 0.5
_EXAMPLES = """2.24, 2.24m, 190cm, 1900 mm, 6'3", 6ft 3in, 75in or inf"""


def parse_distance_m(text: str) -> float:
    """Parse a distance to meters, zero or more; a bare number is in meters.

    Understands m, cm, mm, km, ft, in, feet with inches (6'3", 6 ft 3 in) and inf. Raises InputError
    for anything else: negative, not a number, empty.
    """
    words = with_points(text.strip().lower())
    if words in _INFINITY:
        return math.inf
    distance_m = _feet_and_inches_m(words)
    if distance_m is None:
        distance_m = _one_unit_m(words)
    if distance_m is None or not math.isfinite(distance_m):
        raise InputError(f"{text!r} is not a distance; use {_EXAMPLES}.")
    return distance_m


def is_bare_number(text: str) -> bool:
    """Return True for a number without a unit, whose decimals may follow a comma."""
    return re.fullmatch(_NUMBER, with_points(text.strip().lower())) is not None


def with_points(words: str) -> str:
    """Return the words with decimal points for commas; 1,900, perhaps a thousand, stays."""
    return re.sub(r"(?<=[0-9]),(?=[0-9]{1,2}(?![0-9])|[0-9]{4})", ".", words)


def parse_scene_unit_m(text: str) -> float:
    """Parse a scene's unit to meters: "m", "cm", "mm", "ft", "in", or a positive number of meters.

    Raises InputError for anything else.
    """
    words = text.strip().lower()
    unit_m = _UNIT_M.get(words)
    if unit_m is None:
        match = re.fullmatch(_NUMBER, words)
        unit_m = float(match[1]) if match else 0.0
    if not 0 < unit_m < math.inf:
        raise InputError(
            f"{text!r} is not a scene unit. Use m, cm, mm, km, ft, in or metres per unit, such as "
            "0.01."
        )
    return unit_m


def format_distance(distance_m: float, unit: str = "m") -> str:
    """Format a distance: "2.24 m", "3.67 cm", with unit "ft" 6'3", or "inf"; "unknown" for NaN.

    Four significant digits in meters, three under 10 cm, a tenth of an inch in feet;
    `parse_distance_m` reads all of them. Raises InputError.
    """
    if math.isnan(distance_m):
        return "unknown"
    sign = "-" if distance_m < 0 else ""
    if math.isinf(distance_m):
        return f"{sign}inf"
    if unit == "m":
        return f"{sign}{_metric_text(abs(distance_m))}"
    if unit == "ft":
        return f"{sign}{_feet_text(abs(distance_m))}"
    raise InputError(f"Distances are shown in m or ft, not in {unit!r}.")


def label_distance(distance_m: float, unit: str = "m") -> str:
    """Format a distance to be read at a glance: "12 cm", "0.99 m", "3.70 m", "52 m", 6'3".

    Two significant digits, three from 1 to 10 m; whole inches from a foot on. Zeros at the end
    stay, so that a figure keeps its width while a hand turns it. Fields and files have all that
    `format_distance` tells.
    """
    size_m = abs(distance_m)
    if not 0 < size_m < math.inf or (unit == "ft" and size_m < FOOT_M):
        return format_distance(distance_m, unit)
    sign = "-" if distance_m < 0 else ""
    if unit == "ft":
        return f"{sign}{_feet_text(round(size_m / INCH_M) * INCH_M)}"
    if size_m < _LABEL_CENTIMETRES_UNDER_M:
        return f"{sign}{_two_digits(1e2 * size_m)} cm"
    text = f"{size_m:.2f}"
    return f"{sign}{text if float(text) < 10 else _two_digits(size_m)} m"


def _two_digits(value: float) -> str:
    """Format a positive number to two significant digits, also before the decimal point."""
    rounded = float(f"{value:.1e}")
    return f"{rounded:.{max(0, 1 - math.floor(math.log10(rounded)))}f}"


def _feet_and_inches_m(words: str) -> float | None:
    """Return the meters of 6'3" and similar; None if `words` are something else."""
    match = _FEET_AND_INCHES.fullmatch(words)
    return float(match[1]) * FOOT_M + float(match[2]) * INCH_M if match else None


def _one_unit_m(words: str) -> float | None:
    """Return the meters of a number with one unit or none; None if `words` are something else."""
    match = _ONE_UNIT.fullmatch(words)
    if match is None:
        return None
    unit_m = _UNIT_M.get(match[2] or "m")
    return None if unit_m is None else float(match[1]) * unit_m


def _metric_text(distance_m: float) -> str:
    """Format a distance in meters, or in centimeters under 10 cm."""
    if 0 < distance_m < _CENTIMETRES_UNDER_M:
        return f"{_significant(1e2 * distance_m, _SIGNIFICANT_DIGITS - 1)} cm"
    return f"{_significant(distance_m)} m"


def _significant(value: float, digits: int = _SIGNIFICANT_DIGITS) -> str:
    """Format a positive number to so many significant digits, without trailing zeros."""
    if value == 0:
        return "0"
    decimals = max(0, digits - 1 - math.floor(math.log10(value)))
    text = f"{value:.{decimals}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def _feet_text(distance_m: float) -> str:
    """Format feet and inches; inches are rounded first, so that 11.96 inches become a foot."""
    inches = distance_m / INCH_M
    if round(inches, 1) < 12:
        return f'{_significant(inches)}"'
    feet, remaining_inches = divmod(round(inches, 1), 12)
    return f"{feet:.0f}'{remaining_inches:.1f}".removesuffix(".0") + '"'
