"""Describe how a person sets a dataclass field: its name, help, unit and range.

The description is metadata of the field, from which the command line makes its options and panels
take names and ranges: `width_mm: float = option_field(36.0, "width", least=1)`. For names used in
other programs, and for other unknown names, an option is suggested.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, dataclass, field, fields
from difflib import get_close_matches
from functools import cache
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

from heatlens.core.base.errors import InputError

# Values of fields by name. Their types differ; the dataclass that takes them checks them.
Values = dict[str, Any]

_KEY = "option"  # of an Option in the metadata of a field
# Options by their names in other programs and languages.
OTHER_NAMES = {
    "aperture": "f-stop",
    "blende": "f-stop",
    "brennweite": "focal-length",
    "fnumber": "f-stop",
    "fstop": "f-stop",
    "iris": "f-stop",
    "camera": "scene-camera",
    "focus": "focus-distance",
    "fokus": "focus-distance",
    "lens": "focal-length",
    "out": "output",
    "resolution": "size",
    "samples": "views",
    "sensor": "sensor-width",
}


@dataclass(frozen=True)
class Option:
    """How a user sets a field.

    words     the name of the field in a sentence, such as "focal length"
    help      what it does, for `--help`
    flag      the name of the command-line option, without dashes
    metavar   placeholder of the value in `--help`; "" if the value is one of several words
    unit      unit of the number: "mm", "m", "f-stop" or ""
    least     smallest allowed value; None for no limit
    most      largest allowed value; None for no limit
    parse     converts the typed text and raises InputError; None to decide by type and unit
    asked_by  tells whether a `Method` uses the field; None if every method does
    why_not   end of a sentence about a method that does not use the field
    label     words beside the control in a panel (default: `words`); "" if it is in none
    tip       tooltip of the control (default: `help`)
    slider    ends of a slider, if they are nearer than the range
    shown     how a slider shows the number
    group     the group in `--help`
    term      the field without which this one does not move the focus; "" if it moves none anyhow
    """

    words: str
    help: str = ""
    flag: str = ""
    metavar: str = ""
    unit: str = ""
    least: float | None = None
    most: float | None = None
    parse: Callable[[str], object] | None = None
    asked_by: Callable[[object], bool] | None = None
    why_not: str = ""
    label: str = ""
    tip: str = ""
    slider: tuple[float, float] | None = None
    shown: str = "%.2f"
    group: str = ""
    term: str = ""

    def allows(self, value: float) -> bool:
        """Return whether a number lies in the range; NaN never does."""
        low = -float("inf") if self.least is None else self.least
        high = float("inf") if self.most is None else self.most
        return low <= value <= high


def option(words: str, help: str = "", **settings: Any) -> Mapping[str, Option]:
    """Return the metadata of a field that a person can set; see `Option`."""
    settings = {"flag": words.lower().replace(" ", "-"), "label": words, "tip": help} | settings
    return {_KEY: Option(words, help, **settings)}


def option_field(default: object, words: str, help: str = "", **settings: object) -> Any:
    """Return a dataclass field with a default that a person can set; see `Option`."""
    return field(default=default, metadata=option(words, help, **settings))


def check_range(quantity: str, value: float | None, least: float, most: float) -> None:
    """Raise InputError if a number lies outside its range or is NaN. None always passes."""
    if value is not None and not least <= value <= most:
        raise InputError(f"The {quantity} should be {least:g} to {most:g}, got {value:g}.")


def type_of(dataclass_type: type, name: str) -> Any:
    """Return the type of a field of a dataclass, without None."""
    hint = _hints_of(dataclass_type)[name]
    if get_origin(hint) not in (Union, UnionType):
        return hint
    return next(member for member in get_args(hint) if member is not NoneType)


_hints_of = cache(get_type_hints)


@cache
def options_of(dataclass_type: type) -> Mapping[str, Option]:
    """Return the options of a dataclass by the names of their fields, in their order."""
    return {f.name: f.metadata[_KEY] for f in fields(dataclass_type) if _KEY in f.metadata}


def changed_options(record: Any) -> list[str]:
    """Return the command-line options for all fields that are not at their default.

    `heatlens.fronts.commands.options.field_options` parses them. Only fields with an option and a
    default are included; use it only for records whose values are typed as they are stored.
    """
    arguments = []
    dataclass_type: Any = type(record)
    options = options_of(dataclass_type)
    for record_field in fields(record):
        value = getattr(record, record_field.name)
        if (
            record_field.name in options
            and record_field.default is not MISSING
            and value != record_field.default
        ):
            flag = f"--{options[record_field.name].flag}"
            arguments.append(flag if value is True else f"{flag}={value}")
    return arguments


def known_values(record: object, names: Iterable[str]) -> Values:
    """Return the fields `names` of a record that are not None, by name."""
    values = {name: getattr(record, name) for name in names}
    return {name: value for name, value in values.items() if value is not None}


def suggest_similar(name: str, known: Iterable[str]) -> str:
    """Return " Did you mean X?" for a similar known name, ignoring case; "" if there is none."""
    by_lower_case = {known_name.lower(): known_name for known_name in known}
    similar = get_close_matches(name.lower(), by_lower_case, 1)
    return f" Did you mean {by_lower_case[similar[0]]}?" if similar else ""
