"""Check names, types and values of arguments, so that every mistake is a sentence.

A Python program can pass any object. A value that passes these checks has the type of its field;
the dataclasses of the model check its range.
"""

import difflib
import numbers
import operator
import os
import reprlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields
from enum import StrEnum
from functools import cache
from types import NoneType, UnionType
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FRAME_MOST
from heatlens.core.model.depth_words import KnownDistance, parse_known_distance
from heatlens.core.model.lens.aperture import APERTURE_FIELDS
from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.core.model.option import OTHER_NAMES, Values, options_of
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.media.plate.opening_picture import read_opening_image

Choice = TypeVar("Choice", bound=StrEnum)
_FieldTypes = Mapping[str, tuple[object, ...]]

LENS_VALUES = ("focal_length_mm", "sensor_width_mm", "f_stop", "focus_distance_m")
READING = tuple(field.name for field in fields(PlateOptions))
BLUR = tuple(field.name for field in fields(DefocusSettings))
# The names that each function takes, in the order in which they are listed.
_NAMES = {
    "render": (
        *("lens", "frame", *LENS_VALUES, "focus_at", "lens_model"),
        *(*APERTURE_FIELDS, *BLUR),
    ),
    "open": ("depth_m", "coc_px", "camera", "size", *READING),
}


def check_names(function: str, given: Iterable[str]) -> None:
    """Raise InputError for a name that is not an argument of `function`; suggest what was meant."""
    for name in given:
        if name not in _NAMES[function]:
            raise InputError(f"There is no {name!r}{_meant(function, name)}")


def _meant(function: str, name: str) -> str:
    """Return the end of a sentence: the nearest name, the function that has it, or all names."""
    known = _NAMES[function]
    elsewhere = next((other for other, names in _NAMES.items() if name in names), None)
    if elsewhere is not None:
        return f" in {function}: it is an argument of {elsewhere}."
    other = OTHER_NAMES.get(name.replace("_", "-"), "").replace("-", "_")
    near = [begun for begun in known if other and begun.startswith(other)]
    near = near or difflib.get_close_matches(name, known, 1)
    return f". Did you mean {near[0]}?" if near else f"; there are {', '.join(known)}."


def values_of(kind: type, given: Mapping[str, object]) -> Values:
    """Return values for fields of the dataclass `kind`, each of the type of its field.

    None stays only where the field may be None. Raises InputError for other types.
    """
    types = _types(kind)
    allowed = {n: v for n, v in given.items() if v is not None or NoneType in types[n]}
    return {n: None if v is None else _value(kind, n, v) for n, v in allowed.items()}


@cache
def _types(kind: type) -> _FieldTypes:
    hints = get_type_hints(kind).items()
    return {name: get_args(h) if isinstance(h, UnionType) else (h,) for name, h in hints}


def _value(kind: type, name: str, value: object) -> object:
    hint: object = _types(kind)[name][0]
    origin: object = get_origin(hint)
    if origin is tuple:
        one = get_args(hint)[0]
        return tuple(_single(one, name, item) for item in _items(name, value))
    if hint is float:
        option = options_of(kind).get(name)
        return number(name, value, None if option is None else option.parse)
    return _single(hint, name, value)


def _single(hint: Any, name: str, value: object) -> object:
    return known(hint, name, value) if issubclass(hint, StrEnum) else _READ[hint](name, value)


def _items(name: str, value: object) -> list[object]:
    """Return the items of a list; a single file stands for a list of one."""
    if isinstance(value, str | os.PathLike):
        return [value]
    if isinstance(value, list | tuple):
        return list(value)
    raise _wrong(name, "a list of words", value)


def number(name: str, value: object, parse: Callable[[str], object] | None = None) -> float:
    """Return a number as float. Raises InputError for anything else.

    `parse` reads a value as typed on the command line, for the hint if a text is given.
    """
    value = _python_scalar(value)
    if isinstance(value, str):
        raise _wrong(name, "a number", value, _number_meant(value, parse))
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        raise _wrong(name, "a number", value)
    try:
        return float(value)
    except OverflowError:
        raise InputError(f"{name} is too large a number.") from None


def _number_meant(text: str, parse: Callable[[str], object] | None) -> str:
    """Return ": write 1.8288" for the text "6ft", or "" for a text that is not a number."""
    try:
        return f": write {(parse or float)(text):.6g}"
    except (InputError, ValueError):
        return ""


def whole(name: str, value: Any) -> int:
    """Return a whole number. Raises InputError for anything else, and beyond nine digits."""
    value = _python_scalar(value)
    if not _is_whole(value):
        raise _wrong(name, "a whole number", value)
    integer = operator.index(value)
    if abs(integer) > FRAME_MOST:
        raise InputError(f"{name} is a whole number of at most nine digits.")
    return integer


def _is_whole(value: object) -> bool:
    return isinstance(value, numbers.Integral) and not isinstance(value, bool)


def pair(name: str, meaning: str, value: Any) -> tuple[int, int]:
    """Return two whole numbers; `meaning` says what they are, such as "a pixel (x, y)"."""
    items = list(np.atleast_1d(value)) if isinstance(value, np.ndarray) else value
    is_pair = isinstance(items, list | tuple) and len(items) == 2
    if not is_pair or not all(_is_whole(_python_scalar(item)) for item in items):
        raise _wrong(name, f"{meaning}, two whole numbers", value)
    return whole(name, items[0]), whole(name, items[1])


def text(name: str, value: Any) -> str:
    """Return a word or the name of a file as text. Raises InputError for anything else."""
    words = os.fspath(value) if isinstance(value, str | os.PathLike) else None
    if not isinstance(words, str):
        raise _wrong(name, "a text", value)
    try:
        is_usable = b"\0" not in os.fsencode(words)
    except UnicodeEncodeError:
        is_usable = False
    if not is_usable:
        raise InputError(f"{name} holds characters that a name cannot have: {shown(words)}.")
    return words


def known(kind: type[Choice], name: str, value: object) -> Choice:
    """Return the choice called `value`. Raises InputError if there is none."""
    if isinstance(value, str) and value in list(kind):
        return kind(value)
    raise InputError(f"{name} is one of {', '.join(kind)}, got {shown(value)}.")


def is_single(value: object) -> bool:
    """Return True for a single value, which cannot become an array."""
    is_listed = isinstance(value, list | tuple | memoryview) or hasattr(value, "__array__")
    return not (is_listed or hasattr(value, "__array_interface__")) or _is_scalar(value)


def _flag(name: str, value: object) -> bool:
    value = _python_scalar(value)
    if not isinstance(value, bool):
        raise _wrong(name, "True or False", value)
    return value


def _image(name: str, value: object) -> OpeningImage:
    return value if isinstance(value, OpeningImage) else read_opening_image(text(name, value))


def _known_distance(name: str, value: object) -> KnownDistance:
    return value if isinstance(value, KnownDistance) else parse_known_distance(text(name, value))


_READ: dict[type, Callable[[str, object], object]] = {
    bool: _flag,
    int: whole,
    str: text,
    OpeningImage: _image,
    KnownDistance: _known_distance,
}


def _python_scalar(value: object) -> object:
    """Return the number in a zero-dimensional array, and any other value unchanged."""
    return value.item() if _is_scalar(value) and hasattr(value, "item") else value


def _is_scalar(value: object) -> bool:
    return isinstance(value, np.generic) or getattr(value, "shape", None) == ()


def _wrong(name: str, expected: str, value: object, hint: str = "") -> InputError:
    return InputError(f"{name} must be {expected}, got {shown(value)}{hint}.")


def shown(value: object) -> str:
    """Return a value shortened for a sentence, or its type if it has no short text."""
    try:
        return " ".join(reprlib.repr(value).split())
    except ValueError:  # a whole number of thousands of digits
        return f"a {type(value).__name__}"
