"""Parse typed numbers; argparse puts the name of the option before an error."""

import argparse
import math
import re
import unicodedata

from heatlens.fronts.commands.output.say import print_messages

_LONGEST_LENGTH_MM = 3000.0  # nobody has a lens or a sensor so long
_MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, '"': 25.4}


def parse_whole_number(text: str) -> int:
    """Parse a whole number. Raises ArgumentTypeError."""
    try:
        return int(normalize_digits(text))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number") from None


def normalize_digits(text: str) -> str:
    """Return the text with the usual digits and signs in the place of full-width ones."""
    return unicodedata.normalize("NFKC", text)


def parse_whole_numbers(text: str) -> tuple[int, ...]:
    """Parse whole numbers with commas between them."""
    return tuple(map(parse_whole_number, text.split(",")))


def parse_number(text: str) -> float:
    """Parse a number, also as 2,8; its range is checked later."""
    try:
        return float(use_decimal_point(text))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number") from None


def use_decimal_point(text: str) -> str:
    """Turn 2,8 into 2.8. Three digits after the comma may be thousands, and stay as they are."""
    return re.sub(r"^([-+]?\d+),(\d{1,2}|\d{4,})(?!\d|,)", r"\1.\2", normalize_digits(text).strip())


def parse_f_number(text: str) -> float:
    """Parse the N of f/N: 2.8, f/2.8, F2,8.

    For T2.8 it explains that the blur depends on the f-stop. Raises ArgumentTypeError.
    """
    match = re.fullmatch(
        r"(?i)\s*(f\s*/?|t\s*/?)*\s*(.*?)\s*", normalize_digits(text).replace("ƒ", "f")
    )
    assert match is not None  # everything is matched
    try:
        value = float(use_decimal_point(match[2]))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a number for an f-stop. Examples: 2.8, f/2.8"
        ) from None
    if (match[1] or "").lower().startswith("t"):
        print_messages(
            f"{text} is taken as f/{value:g}. A T-stop also counts the light lost in the glass; "
            "the blur depends on the f-stop, which is a little lower."
        )
    return value


def parse_millimeters(text: str) -> float:
    """Parse a length on the lens or sensor: 50, 50mm, 5cm, 2in.

    Without a unit it is millimeters. Raises ArgumentTypeError.
    """
    match = re.fullmatch(r"(?i)\s*(.*?)\s*(mm|cm|m|in|\")?\s*", text)
    assert match is not None  # everything is matched
    unit = (match[2] or "mm").lower()
    try:
        value = float(use_decimal_point(match[1])) * _MILLIMETRES[unit]
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a number of millimetres. Examples: 50, 50mm"
        ) from None
    if unit == "m" and value >= _LONGEST_LENGTH_MM:
        raise argparse.ArgumentTypeError(f"{text!r} is {value:g} mm. Did you mean {match[1]}mm?")
    return value


def parse_finite(text: str) -> float:
    """Parse a finite number. Raises ArgumentTypeError."""
    value = parse_number(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is not a finite number")
    return value


def parse_positive(text: str) -> float:
    """Parse a finite number above 0. Raises ArgumentTypeError."""
    value = parse_finite(text)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number above 0")
    return value
