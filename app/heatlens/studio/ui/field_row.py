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

    A value without a control is shown as text; its tooltip says where to set it.
    """
    changed: dict[str, Any] = {name: _value(type(record), name, getattr(record, name))}
    return replace(record, **changed)


def _value(kind: type, name: str, value: Any) -> Any:
    option, of_type = options_of(kind)[name], type_of(kind, name)
    low, high = option.slider or (option.least, option.most)
    if of_type is bool:
        value = widgets.check(option.label, value)
        texts.tip_above(option.tip)
        return value
    if get_origin(of_type) is Literal:
        return widgets.choice(option.label, value, get_args(of_type), option.tip)
    if issubclass(of_type, StrEnum):
        return of_type(widgets.choice(option.label, value, list(of_type), option.tip))
    if of_type in (float, int) and low is not None and high is not None:
        return of_type(widgets.slider(option.label, value, low, high, option.shown, option.tip))
    if of_type is str:
        widgets.label(option.label, option.tip, is_above=True)
        return widgets.typed(option.label, value)
    widgets.label(option.label, f"{option.tip}\nSet it with --{option.flag}.")
    imgui.text_disabled(printable(str(value)))
    return value
