"""Draw small controls that ImGui lacks; each takes a value and returns the user's new value."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from enum import Enum
from typing import TypeVar

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.errors import InputError
from heatlens.core.base.messages import Problem
from heatlens.core.base.outside_text import printable
from heatlens.studio.ui import rects, theme
from heatlens.studio.ui.seek import is_highlighted
from heatlens.studio.ui.texts import disabled_tip, tooltip

Value = TypeVar("Value")
Key = TypeVar("Key")
Member = TypeVar("Member", bound=Enum)

LABEL_EM = 6.6  # width of the column of labels
_DRAGGING, _TYPING_BEGINS, _TYPING = 0, 1, 2  # how a number is edited at the moment
VALUE_EM = 5.2  # width of the column of values beside sliders


def label(text: str, tip: str = "", is_above: bool = False) -> None:
    """Draw the label before a control; the next control then fills the rest of the line.

    With `is_above` the control has a line of its own under the label.
    """
    imgui.align_text_to_frame_padding()
    if is_highlighted(text):
        imgui.text_colored(theme.colors.trial, text)
    else:
        imgui.text_disabled(text)
    tooltip(tip)
    if not is_above:
        imgui.same_line(LABEL_EM * imgui.get_font_size())
    imgui.set_next_item_width(-1)


def drag(
    name: str,
    value: float,
    speed: float,
    low: float,
    high: float,
    format_: str,
    notify: Callable[[str], None],
    tip: str = "",
) -> float:
    """Draw a number field: drag to change it; Ctrl+click or double click to type.

    The value is rounded only when it changes. If the typed text is invalid, the error is passed to
    `notify` and the value stays.
    """
    label(name, tip)
    storage, stage_id = imgui.get_state_storage(), imgui.get_id(f"{name} is typed")
    stage = storage.get_int(stage_id, _DRAGGING)
    if stage != _DRAGGING:
        return _typed_number(name, value, low, high, format_, notify, stage_id)
    flags = imgui.SliderFlags_.logarithmic | imgui.SliderFlags_.no_input
    has_changed, new_value = imgui.drag_float(f"##{name}", value, speed, low, high, format_, flags)
    rects.note(name)
    is_clicked = imgui.is_mouse_clicked(imgui.MouseButton_.left) and imgui.get_io().key_ctrl
    is_double = imgui.is_mouse_double_clicked(imgui.MouseButton_.left)
    if imgui.is_item_hovered() and (is_clicked or is_double):
        imgui.internal.clear_active_id()
        storage.set_int(stage_id, _TYPING_BEGINS)
    return float(f"{new_value:.7g}") if has_changed else value


def _typed_number(
    name: str,
    value: float,
    low: float,
    high: float,
    format_: str,
    notify: Callable[[str], None],
    stage_id: int,
) -> float:
    """Draw the number as a text field until it is left; `stage_id` is the id of its stage."""
    storage, value_text = imgui.get_state_storage(), (format_ % value).split()[0]
    is_new = storage.get_int(stage_id, _DRAGGING) == _TYPING_BEGINS
    if is_new:
        imgui.set_keyboard_focus_here()
        storage.set_int(stage_id, _TYPING)
    new_value = text_field(
        name, value_text, value, lambda text: parse_number(text, low, high, name), notify
    )
    if not is_new and not imgui.is_item_active():
        storage.set_int(stage_id, _DRAGGING)
    return new_value


def slider(name: str, value: float, low: float, high: float, format_: str, tip: str = "") -> float:
    """Draw a slider with its number beside it, where the grab does not hide the number."""
    label(name, tip)
    imgui.set_next_item_width(imgui.get_content_region_avail().x - VALUE_EM * imgui.get_font_size())
    flags = imgui.SliderFlags_.always_clamp  # also clamps a number typed after Ctrl+click
    has_changed, new_value = imgui.slider_float(f"##{name}", value, low, high, "", flags)
    rects.note(name)
    imgui.same_line()
    imgui.text(format_ % value)
    return float(f"{new_value:.7g}") if has_changed else value


def choice(
    name: str,
    value: str,
    choices: Sequence[str],
    tip: str = "",
    barred: Mapping[str, str] | None = None,
) -> str:
    """Draw a drop-down of `choices`; `barred` gives the reason for those that are unavailable."""
    label(name, tip)
    width = imgui.get_content_region_avail().x - imgui.get_frame_height()
    is_cut = imgui.calc_text_size(printable(value)).x > width - imgui.get_style().frame_padding.x
    if imgui.begin_combo(f"##{name}", printable(value), imgui.ComboFlags_.height_large):
        for index, item in enumerate(choices):
            reason = (barred or {}).get(item, "")
            with disabled(bool(reason)):
                is_picked, _ = imgui.selectable(f"{printable(item)}##{index}", item == value)
            rects.note(f"{name}: {item}")
            disabled_tip(reason)
            if is_picked:
                value = item
        imgui.end_combo()
    elif is_cut:
        tooltip(value)
    rects.note(name)
    return value


def pick(
    name: str,
    value: Key,
    words: Mapping[Key, str],
    tip: str = "",
    barred: Mapping[str, str] | None = None,
) -> Key:
    """Draw a drop-down of the texts `words`; return the key of the chosen text.

    A value that has no text is shown as "custom", and stays until the user chooses another.
    """
    picked_text = choice(name, words.get(value, "custom"), list(words.values()), tip, barred)
    return next((key for key, text in words.items() if text == picked_text), value)


def pick_one(
    name: str, value: Member, tip: str = "", barred: Mapping[str, str] | None = None
) -> Member:
    """Draw a drop-down of all members of the enum of `value`; return the chosen member."""
    return pick(name, value, {member: str(member) for member in type(value)}, tip, barred)


def button(words: str, name: str, tip: str = "", width: float = 0.0) -> bool:
    """Draw a button, known to `rects` by `name`; return True if it was pressed.

    `width` is in screen units: 0 for that of the words, negative to fill the line.
    """
    is_pressed = imgui.button(words, ImVec2(width, 0))
    rects.note(name)
    tooltip(tip)
    return bool(is_pressed)


def small_button(words: str, name: str, tip: str = "") -> bool:
    """Draw a button as high as a line of text, see `button`."""
    is_pressed = imgui.small_button(words)
    rects.note(name)
    tooltip(tip)
    return bool(is_pressed)


def invisible_button(name: str, corner: ImVec2, size: ImVec2, tip: str = "") -> bool:
    """Draw an invisible button in a part of the screen; return True if it was clicked."""
    imgui.set_cursor_screen_pos(corner)
    is_pressed = imgui.invisible_button(name, size)
    rects.note(name)
    tooltip(tip)
    return bool(is_pressed)


def check(words: str, value: bool, name: str = "", tip: str = "") -> bool:
    """Draw a checkbox, known to `rects` by `name` or by its words; return the new value."""
    _, value = imgui.checkbox(words, value)
    rects.note(name or words)
    tooltip(tip)
    return bool(value)


def typed_text(name: str, value: str) -> str:
    """Draw a text field without a label; return its text while it is being typed.

    Of a text that is longer than the field the end is seen, which tells one path from another.
    """
    _, text = imgui.input_text(f"##{name}", value, imgui.InputTextFlags_.elide_left)
    rects.note(name)
    return str(text)


def text_field(
    name: str,
    value_text: str,
    value: Value,
    parse: Callable[[str], Value],
    notify: Callable[[str], None],
    hint: str = "",
) -> Value:
    """Draw a text field; return the parsed value once the user has finished typing.

    If `parse` raises InputError, the error is passed to `notify` and the value stays. `hint` is
    shown while the field is empty.
    """
    flags = imgui.InputTextFlags_.auto_select_all
    _, text = imgui.input_text_with_hint(f"##{name}", hint, value_text, flags)
    rects.note(name)
    if imgui.is_item_deactivated_after_edit() and text != value_text:
        try:
            return parse(text)
        except InputError as error:
            notify(Problem(error))
    return value


def optional(parse: Callable[[str], Value]) -> Callable[[str], Value | None]:
    """Return `parse`, but with None for an empty text."""
    return lambda text: parse(text) if text.strip() else None


def fact_row(words: str, text: str, name: str) -> None:
    """Draw a label and a text, wrapped over several lines; `rects` knows it by `name`."""
    imgui.text_disabled(words)
    imgui.same_line(LABEL_EM * imgui.get_font_size())
    imgui.text_wrapped(printable(text))
    rects.note(name)


def folded_header(name: str, labels: Sequence[str], is_used: bool = False) -> bool:
    """Draw a header that is closed at first; return True if it is open.

    The header opens when `is_used` becomes true, and when the palette shows the setting with one of
    the `labels`.
    """
    storage, used_id = imgui.get_state_storage(), imgui.get_id(f"{name} is used")
    is_newly_used = is_used and not storage.get_bool(used_id)
    storage.set_bool(used_id, is_used)
    if is_newly_used or any(is_highlighted(label, scrolls=False) for label in labels):
        imgui.set_next_item_open(True)
    is_open = imgui.collapsing_header(name)
    rects.note(name)
    return bool(is_open)


@contextmanager
def disabled(is_disabled: bool) -> Iterator[None]:
    """Disable the controls of the block if `is_disabled` is True."""
    imgui.begin_disabled(is_disabled)
    try:
        yield
    finally:
        imgui.end_disabled()


def wheel_over_last() -> float:
    """Return the wheel notches over the last item and keep them from scrolling its panel."""
    if not imgui.is_item_hovered():
        return 0.0
    imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
    return float(imgui.get_io().mouse_wheel)


def parse_number(text: str, low: float, high: float, quantity: str) -> float:
    """Parse a number, with or without a leading f/ or T. Raise InputError outside the limits."""
    number_text = text.strip().lower().removeprefix("f/").removeprefix("f").removeprefix("t")
    try:
        value = float(_without_unit(number_text).replace(",", "."))
    except ValueError:
        raise InputError(
            f"{text!r} is not a number for the {quantity}. Example: {low:g}."
        ) from None
    if not low <= value <= high:
        raise InputError(f"The {quantity} must be {low:g} to {high:g}, got {value:g}.")
    return value


def _without_unit(text: str) -> str:
    """Return the text without a unit at its end."""
    for unit in ("mm", "µm", "um", "x", "%"):
        text = text.removesuffix(unit)
    return text.strip()


def spacer() -> None:
    """Leave a small vertical gap."""
    imgui.dummy(ImVec2(0, 0.3 * imgui.get_font_size()))
