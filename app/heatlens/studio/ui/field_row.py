"""Draw the control for a field of a dataclass that fits its type and option."""

from dataclasses import replace
from enum import StrEnum
from typing import TYPE_CHECKING, Any, Literal, TypeVar, get_args, get_origin

from imgui_bundle import imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.option import options_of, type_of
from heatlens.studio.ui import texts, widgets

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Record = TypeVar("Record", bound="DataclassInstance")


def field_row(record: Record, name: str) -> Record:
    """Draw the row of a field; return the record with its value as the user left it.

    A value without a control is shown as text; its tooltip explains where to set it.
    """
    changes: dict[str, Any] = {name: _draw_control(type(record), name, getattr(record, name))}
    return replace(record, **changes)


def _draw_control(kind: type, name: str, value: Any) -> Any:
    """Draw the control of a field of the dataclass `kind`; return the value as the user left it."""
    option, value_type = options_of(kind)[name], type_of(kind, name)
    low, high = option.slider or (option.least, option.most)
    if value_type is bool:
        value = widgets.check(option.label, value)
        texts.tip_above(option.tip)
        return value
    if get_origin(value_type) is Literal:
        return widgets.choice(option.label, value, get_args(value_type), option.tip)
    if issubclass(value_type, StrEnum):
        return value_type(widgets.choice(option.label, value, list(value_type), option.tip))
    if value_type in (float, int) and low is not None and high is not None:
        return value_type(widgets.slider(option.label, value, low, high, option.shown, option.tip))
    if value_type is str:
        widgets.label(option.label, option.tip, is_above=True)
        return widgets.typed_text(option.label, value)
    widgets.label(option.label, f"{option.tip}\nSet it with --{option.flag}.")
    imgui.text_disabled(printable(str(value)))
    return value
