"""Make command-line options from the fields of settings, and read the values typed for them.

The range, unit and help of an option are defined on its field, see `heatlens.core.model.option`.
The options of the blur, which many commands share, are also made here.
"""

import argparse
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from enum import StrEnum
from typing import Any, Literal, get_args, get_origin

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.core.model.option import Option, Values, options_of, type_of
from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.fronts.commands.options.value_types import (
    parse_f_number,
    parse_finite,
    parse_millimeters,
    parse_number,
    parse_whole_number,
    use_decimal_point,
)

_NUMBERS: dict[str, Callable[[str], float]] = {
    "": parse_number,
    "mm": parse_millimeters,
    "m": parse_finite,
    "f-stop": parse_f_number,
}
Group = argparse.ArgumentParser | argparse._ArgumentGroup
_DEFAULT_SETTINGS = DefocusSettings()


def add_fields(group: Group, kind: type, names: Iterable[str] = ()) -> None:
    """Add the options of the fields `names` of a dataclass to a parser or group; default all."""
    options = options_of(kind)
    for name in names or options:
        group.add_argument(
            flag_of(kind, name), **_argument_keywords(type_of(kind, name), options[name])
        )


def flag_of(kind: type, name: str) -> str:
    """Return the option of a field as it is typed: "--focal-length"."""
    return f"--{options_of(kind)[name].flag}"


def given_fields(args: argparse.Namespace, kind: type, names: Iterable[str] = ()) -> Values:
    """Return the given values for fields of a dataclass, without those that were not given.

    Raises InputError for values that cannot be read, and for numbers outside their range.
    """
    options, values = options_of(kind), {}
    for name in names or options:
        value = getattr(args, _attribute_name(options[name]), None)
        if value is not None and value is not False:
            values[name] = _convert_value(value, type_of(kind, name), options[name])
    return values


def fill_fields(args: argparse.Namespace, record: object) -> None:
    """Set the options that were not typed to the values of `record`, except default values."""
    kind: Any = type(record)
    for name, option in options_of(kind).items():
        typed_value, value = getattr(args, _attribute_name(option)), getattr(record, name)
        if (typed_value is None or typed_value is False) and value != getattr(kind(), name):
            setattr(args, _attribute_name(option), value)


def set_fields(args: argparse.Namespace, kind: type, values: Mapping[str, object]) -> None:
    """Set the options of fields to `values`, by the names of the fields."""
    for name, option in options_of(kind).items():
        if values.get(name) is not None:
            setattr(args, _attribute_name(option), values[name])


def attribute_names(kind: type, names: Iterable[str] = ()) -> tuple[str, ...]:
    """Return the attributes of parsed arguments that hold the options of fields."""
    options = options_of(kind)
    return tuple(_attribute_name(options[name]) for name in names or options)


def unused_blur_options(method: Method) -> dict[str, list[str]]:
    """Return the attributes of blur options that a method ignores, grouped by the reason."""
    attributes: dict[str, list[str]] = {}
    for option in options_of(DefocusSettings).values():
        if option.asked_by is not None and not option.asked_by(method):
            attributes.setdefault(option.why_not, []).append(_attribute_name(option))
    return attributes


def _attribute_name(option: Option) -> str:
    return option.flag.replace("-", "_")


def _argument_keywords(kind: Any, option: Option) -> Values:
    """Return the keyword arguments of `add_argument` for an option."""
    if kind is bool:
        return {"action": "store_true", "help": option.help}
    if get_origin(kind) is tuple:
        return {"action": "append", "metavar": option.metavar, "help": option.help}
    if get_origin(kind) is Literal:
        return {"choices": get_args(kind), "help": option.help}
    if issubclass(kind, StrEnum):
        return {"choices": [str(member) for member in kind], "help": option.help}
    keywords: dict[str, object] = {"metavar": option.metavar, "help": option.help}
    if option.parse is None and kind in (int, float):
        keywords["type"] = parse_whole_number if kind is int else _NUMBERS[option.unit]
    return keywords


def _convert_value(typed_value: Any, kind: Any, option: Option) -> Any:
    """Return a typed value converted to the type of its field. Raises InputError if impossible."""
    if get_origin(kind) is tuple:
        return tuple(_convert_value(item, get_args(kind)[0], option) for item in typed_value)
    if kind is OpeningImage:
        from heatlens.media.plate.opening_picture import read_opening_image

        return (
            typed_value
            if isinstance(typed_value, OpeningImage)
            else read_opening_image(typed_value)
        )
    if get_origin(kind) is Literal:
        return typed_value
    if option.parse is not None and isinstance(typed_value, str):
        return option.parse(use_decimal_point(typed_value) if kind is float else typed_value)
    if issubclass(kind, StrEnum):
        return kind(typed_value)
    if kind in (int, float):
        _check_range(typed_value, option)
    return typed_value


def _check_range(value: float, option: Option) -> None:
    """Raise InputError for a number out of range; the model checks those with a unit."""
    if option.least is not None and not option.unit and not option.allows(value):
        low, high = option.least, option.most
        raise InputError(f"--{option.flag} must be {low:g} to {high:g}, got {value:g}.")


def add_blur_options(parser: argparse.ArgumentParser) -> None:
    """Add the group `blur` to `parser`: an option for each field of DefocusSettings."""
    group = parser.add_argument_group("blur", "How the blur is computed, not how large it is.")
    add_fields(group, DefocusSettings)


def settings_of(
    args: argparse.Namespace, defaults: DefocusSettings = _DEFAULT_SETTINGS
) -> DefocusSettings:
    """Return the blur settings of the options; missing ones are taken from `defaults`.

    Raises InputError for impossible numbers.
    """
    return replace(defaults, **given_fields(args, DefocusSettings))
