"""Draw buttons that stay pressed: one alone, or a row of them for the values of a choice."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import TypeVar

from imgui_bundle import imgui

from heatlens.studio.ui import texts, theme, widgets

Key = TypeVar("Key")

_GAP = 2.0  # between the buttons of one choice, in screen units


def toggle_button(words: str, name: str, is_on: bool, tip: str = "", width: float = 0.0) -> bool:
    """Draw a button, highlighted while it is on, see `button`; return True if it was pressed."""
    if is_on:
        knob = imgui.get_style_color_vec4(imgui.Col_.check_mark)
        imgui.push_style_color(imgui.Col_.button, knob)
        imgui.push_style_color(imgui.Col_.button_hovered, knob)
        imgui.push_style_color(imgui.Col_.text, theme.colors.on_accent)
    is_pressed = widgets.button(words, name, width=width)
    if is_on:
        imgui.pop_style_color(3)
    texts.tooltip(tip)
    return is_pressed


def segments(
    name: str,
    value: Key,
    words: Mapping[Key, str],
    per_row: int,
    tip: str = "",
    tips: Mapping[Key, str] = MappingProxyType({}),
) -> Key:
    """Draw a button for each value, in rows of `per_row`; return the value that was pressed.

    `tip` is on the name of the choice, and `tips` are on the buttons.
    """
    widgets.label(name, tip)
    left, free_width = imgui.get_cursor_pos_x(), imgui.get_content_region_avail().x
    text_widths = [imgui.calc_text_size(text).x for text in words.values()]
    columns = [max(text_widths[column::per_row]) for column in range(per_row)]
    padding = (free_width - sum(columns) - _GAP * (per_row - 1)) / per_row
    chosen = value
    for index, (key, text) in enumerate(words.items()):
        column = index % per_row
        x = left + sum(columns[:column]) + column * (padding + _GAP)
        if column:
            imgui.same_line(x)
        else:
            imgui.set_cursor_pos_x(x)
        width = columns[column] + padding
        button_name, is_on = f"{name} {text}", key == value
        if toggle_button(f"{text}##{name}", button_name, is_on, tips.get(key, ""), width):
            chosen = key
    return chosen
