"""Parse typed numbers; argparse puts the name of the option before an error."""

import argparse
import math
import re
import unicodedata

from heatlens.fronts.commands.output.say import say

_METRES_MEANT_MM = 3000.0  # nobody has a lens or a sensor so long
_MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, '"': 25.4}


def whole(text: str) -> int:
    """Parse a whole number."""
    try:
        return int(plain(text))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number") from None


def plain(text: str) -> str:
    """Return the text with the usual digits and signs in the place of full-width ones."""
    return unicodedata.normalize("NFKC", text)


def wholes(text: str) -> tuple[int, ...]:
    """Parse whole numbers with commas between them."""
    return tuple(map(whole, text.split(",")))


def number(text: str) -> float:
    """Parse a number, also as 2,8; its range is checked later."""
    try:
        return float(with_point(text))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number") from None


def with_point(text: str) -> str:
    """Turn 2,8 into 2.8. Three digits after the comma may be thousands, and stay as they are."""
    return re.sub(r"^([-+]?\d+),(\d{1,2}|\d{4,})(?!\d|,)", r"\1.\2", plain(text).strip())


def f_number(text: str) -> float:
    """Parse the N of f/N: 2.8, f/2.8, F2,8.

    For T2.8 it explains that the blur depends on the f-stop.
    """
    match = re.fullmatch(r"(?i)\s*(f\s*/?|t\s*/?)*\s*(.*?)\s*", plain(text).replace("ƒ", "f"))
    assert match is not None  # everything is matched
    try:
        value = float(with_point(match[2]))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a number for an f-stop. Examples: 2.8, f/2.8"
        ) from None
    if (match[1] or "").lower().startswith("t"):
        say(
            f"{text} is taken as f/{value:g}. A T-stop also counts the light lost in the glass; "
            "the blur depends on the f-stop, which is a little lower."
        )
    return value


def millimetres(text: str) -> float:
    """Parse a length on the lens or sensor: 50, 50mm, 5cm, 2in.

    Without a unit it is millimetres.
    """
    match = re.fullmatch(r"(?i)\s*(.*?)\s*(mm|cm|m|in|\")?\s*", text)
    assert match is not None  # everything is matched
    unit = (match[2] or "mm").lower()
    try:
        value = float(with_point(match[1])) * _MILLIMETRES[unit]
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a number of millimetres. Examples: 50, 50mm"
        ) from None
    if unit == "m" and value >= _METRES_MEANT_MM:
        raise argparse.ArgumentTypeError(f"{text!r} is {value:g} mm. Did you mean {match[1]}mm?")
    return value


def finite(text: str) -> float:
    """Parse a finite number."""
    value = number(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is not a finite number")
    return value


def positive(text: str) -> float:
    """Parse a finite number above 0."""
    value = finite(text)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number above 0")
    return value
