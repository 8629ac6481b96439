"""Check names, types and values of arguments, and raise errors with clear messages.

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
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FRAME_MOST
from heatlens.core.model.depth_words import KnownDistance, parse_known_distance
from heatlens.core.model.lens.aperture import APERTURE_FIELDS
from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.core.model.option import OTHER_NAMES, Values, options_of
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.deliver.export.options import ExportOptions
from heatlens.media.plate.opening_picture import read_opening_image

Choice = TypeVar("Choice", bound=StrEnum)
_FieldTypes = Mapping[str, tuple[object, ...]]

LENS_VALUES = ("focal_length_mm", "sensor_width_mm", "f_stop", "focus_distance_m")
PLATE_OPTION_NAMES = tuple(field.name for field in fields(PlateOptions))
EXPORT_OPTION_NAMES = tuple(field.name for field in fields(ExportOptions))
BLUR_OPTION_NAMES = tuple(field.name for field in fields(DefocusSettings))
# The names that each function takes, in the order in which they are listed.
_NAMES = {
    "render": (
        *("lens", "frame", *LENS_VALUES, "focus_at", "lens_model"),
        *(*APERTURE_FIELDS, *BLUR_OPTION_NAMES),
    ),
    "export": (
        *("lens", "output", "progress", "is_cancelled", *LENS_VALUES, "focus_at", "lens_model"),
        *(*APERTURE_FIELDS, *BLUR_OPTION_NAMES, *EXPORT_OPTION_NAMES),
    ),
    "open": ("depth_m", "coc_px", "camera", "size", *PLATE_OPTION_NAMES),
}


def check_names(function: str, names: Iterable[str]) -> None:
    """Raise InputError for a name that is not an argument of `function`, with a suggestion."""
    for name in names:
        if name not in _NAMES[function]:
            raise InputError(f"There is no argument {name!r}{_suggestion(function, name)}")


def _suggestion(function: str, name: str) -> str:
    """Return the end of the error for an unknown name.

    It suggests the function that has the argument, else the nearest name, else all names.
    """
    known_names = _NAMES[function]
    other_function = next((owner for owner, names in _NAMES.items() if name in names), None)
    if other_function is not None:
        return f" in {function}: it is an argument of {other_function}."
    option_elsewhere = OTHER_NAMES.get(name.replace("_", "-"), "").replace("-", "_")
    near_names = [
        known_name
        for known_name in known_names
        if option_elsewhere and known_name.startswith(option_elsewhere)
    ]
    near_names = near_names or difflib.get_close_matches(name, known_names, 1)
    return (
        f". Did you mean {near_names[0]}?"
        if near_names
        else f"; there are {', '.join(known_names)}."
    )


def check_values(kind: type, values: Mapping[str, object]) -> Values:
    """Return values for fields of the dataclass `kind`, each converted to the type of its field.

    A value of None is left out unless the field may be None. Raises InputError for other types.
    """
    types = _field_types(kind)
    allowed = {
        name: value
        for name, value in values.items()
        if value is not None or NoneType in types[name]
    }
    return {
        name: None if value is None else _check_value(kind, name, value)
        for name, value in allowed.items()
    }


@cache
def _field_types(kind: type) -> _FieldTypes:
    """Return the types that each field of a dataclass may have."""
    hints = get_type_hints(kind).items()
    return {
        name: get_args(hint) if isinstance(hint, UnionType) else (hint,) for name, hint in hints
    }


def _check_value(kind: type, name: str, value: object) -> object:
    """Return a value that is not None, converted to the type of the field `name` of `kind`."""
    hint: object = _field_types(kind)[name][0]
    origin: object = get_origin(hint)
    if origin is tuple:
        item_type = get_args(hint)[0]
        return tuple(
            _check_single_value(item_type, name, item) for item in _list_items(name, value)
        )
    if origin is Literal:
        if value in get_args(hint):
            return value
        raise InputError(f"{name} is one of {', '.join(get_args(hint))}, got {short_repr(value)}.")
    if hint is float:
        option = options_of(kind).get(name)
        return check_number(name, value, None if option is None else option.parse)
    return _check_single_value(hint, name, value)


def _check_single_value(hint: Any, name: str, value: object) -> object:
    """Return a single value converted to the type `hint`. Raises InputError for other types."""
    return (
        check_choice(hint, name, value)
        if issubclass(hint, StrEnum)
        else _PARSERS[hint](name, value)
    )


def _list_items(name: str, value: object) -> list[object]:
    """Return the items of a list; a single file stands for a list of one. Raises InputError."""
    if isinstance(value, str | os.PathLike):
        return [value]
    if isinstance(value, list | tuple):
        return list(value)
    raise _type_error(name, "a list of words", value)


def check_number(name: str, value: object, parse: Callable[[str], object] | None = None) -> float:
    """Return a number as float. Raises InputError for anything else.

    `parse` reads a text as on the command line; it is used only for the hint in the error message.
    """
    value = _python_scalar(value)
    if isinstance(value, str):
        raise _type_error(name, "a number", value, _number_hint(value, parse))
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        raise _type_error(name, "a number", value)
    try:
        return float(value)
    except OverflowError:
        raise InputError(f"{name} is too large a number: the most is about 1.8e308.") from None


def _number_hint(text: str, parse: Callable[[str], object] | None) -> str:
    """Return ": write 1.8288" for the text "6ft", or "" for a text that is not a number."""
    try:
        return f": write {(parse or float)(text):.6g}"
    except (InputError, ValueError):
        return ""


def check_whole_number(name: str, value: Any) -> int:
    """Return a whole number. Raises InputError for anything else, and beyond nine digits."""
    value = _python_scalar(value)
    if not _is_whole_number(value):
        raise _type_error(name, "a whole number", value)
    integer = operator.index(value)
    if abs(integer) > FRAME_MOST:
        raise InputError(f"{name} is a whole number of at most nine digits.")
    return integer


def _is_whole_number(value: object) -> bool:
    return isinstance(value, numbers.Integral) and not isinstance(value, bool)


def check_pair(name: str, meaning: str, value: Any) -> tuple[int, int]:
    """Return two whole numbers; `meaning` says what they are, such as "a pixel (x, y)"."""
    items = list(np.atleast_1d(value)) if isinstance(value, np.ndarray) else value
    is_pair = isinstance(items, list | tuple) and len(items) == 2
    if not is_pair or not all(_is_whole_number(_python_scalar(item)) for item in items):
        raise _type_error(name, f"{meaning}, two whole numbers", value)
    return check_whole_number(name, items[0]), check_whole_number(name, items[1])


def check_text(name: str, value: Any) -> str:
    """Return a word or the name of a file as text. Raises InputError for anything else."""
    words = os.fspath(value) if isinstance(value, str | os.PathLike) else None
    if not isinstance(words, str):
        raise _type_error(name, "a text", value)
    try:
        is_usable = b"\0" not in os.fsencode(words)
    except UnicodeEncodeError:
        is_usable = False
    if not is_usable:
        raise InputError(f"{name} holds characters that a name cannot have: {short_repr(words)}.")
    return words


def check_choice(kind: type[Choice], name: str, value: object) -> Choice:
    """Return the choice called `value`. Raises InputError if there is none."""
    if isinstance(value, str) and value in list(kind):
        return kind(value)
    raise InputError(f"{name} is one of {', '.join(kind)}, got {short_repr(value)}.")


def is_single(value: object) -> bool:
    """Return True for a single value, which cannot become an array."""
    is_listed = isinstance(value, list | tuple | memoryview) or hasattr(value, "__array__")
    return not (is_listed or hasattr(value, "__array_interface__")) or _is_scalar(value)


def _check_flag(name: str, value: object) -> bool:
    """Return a bool, also of NumPy. Raises InputError for anything else."""
    value = _python_scalar(value)
    if not isinstance(value, bool):
        raise _type_error(name, "True or False", value)
    return value


def _check_image(name: str, value: object) -> OpeningImage:
    """Return the value as an opening's image; a text is a path to read. Raises InputError."""
    return value if isinstance(value, OpeningImage) else read_opening_image(check_text(name, value))


def _known_distance(name: str, value: object) -> KnownDistance:
    """Return the value as a known distance; a text is parsed. Raises InputError."""
    return (
        value if isinstance(value, KnownDistance) else parse_known_distance(check_text(name, value))
    )


_PARSERS: dict[type, Callable[[str, object], object]] = {
    bool: _check_flag,
    int: check_whole_number,
    str: check_text,
    OpeningImage: _check_image,
    KnownDistance: _known_distance,
}


def _python_scalar(value: object) -> object:
    """Return the number in a zero-dimensional array, and any other value unchanged."""
    return value.item() if _is_scalar(value) and hasattr(value, "item") else value


def _is_scalar(value: object) -> bool:
    return isinstance(value, np.generic) or getattr(value, "shape", None) == ()


def _type_error(name: str, expected: str, value: object, hint: str = "") -> InputError:
    return InputError(f"{name} must be {expected}, got {short_repr(value)}{hint}.")


def short_repr(value: object) -> str:
    """Return a value as a short text for a message, or its type if it has no short text."""
    try:
        return " ".join(reprlib.repr(value).split())
    except ValueError:  # a whole number of thousands of digits
        return f"a {type(value).__name__}"
