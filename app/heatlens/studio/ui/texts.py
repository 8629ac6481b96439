"""Draw words: in color, cut to a width, as tooltips, and distances at a glance."""

import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from imgui_bundle import ImVec2, ImVec4, imgui

from heatlens.core.base.outside_text import printable
from heatlens.core.model.lens.lens import Lens, as_measured_m
from heatlens.core.model.units import label_distance


def named_keys(text: str) -> str:
    """Return a text with the names that keys have on this system: on a Mac Cmd is used as Ctrl."""
    return re.sub(r"\bCtrl\b", "Cmd", text) if sys.platform == "darwin" else text


def tooltip(text: str) -> None:
    """Show a tooltip while the pointer rests on the last item; none if `text` is empty."""
    if text and imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
        imgui.set_tooltip(named_keys(printable(text, keep="\n")))


def tip_above(text: str) -> None:
    """Show a tooltip above the last item, where it covers nothing that comes after it."""
    if imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
        imgui.set_next_window_pos(imgui.get_item_rect_min(), 0, ImVec2(0.0, 1.0))
        imgui.set_tooltip(named_keys(text))


def disabled_tip(reason: str) -> None:
    """Show the reason why the last item is disabled as its tooltip; nothing if it is empty."""
    if reason and imgui.is_item_hovered(imgui.HoveredFlags_.allow_when_disabled):
        imgui.set_tooltip(named_keys(printable(reason)))


def colored_text(text: str, color: ImVec4) -> None:
    """Draw a text in color, wrapped over several lines; draw nothing if it is empty."""
    if not text:
        return
    with colored(color):
        imgui.text_wrapped(named_keys(printable(text, keep="\n")))


def gray_text(text: str) -> None:
    """Draw a text that is of less importance, wrapped over several lines."""
    colored_text(text, imgui.get_style_color_vec4(imgui.Col_.text_disabled))


def text_width(text: str) -> float:
    """Return the width of a text in screen units."""
    return float(imgui.calc_text_size(text).x)


def fit_text(
    text: str, width: float, keeps_end: bool = False, width_of: Callable[[str], float] = text_width
) -> str:
    """Return the text, shortened with three dots to fit into `width` screen units.

    `keeps_end` cuts off the beginning instead of the end, for folders.
    """

    def cut_to(letter_count: int) -> str:
        """Return the text with only so many letters, and dots for the others."""
        return (
            f"...{text[len(text) - letter_count :]}"
            if keeps_end
            else f"{text[:letter_count].rstrip()} ..."
        )

    if width_of(text) <= width:
        return text
    low, high = 0, len(text)
    while low < high:  # binary search for the longest part that fits
        middle = (low + high + 1) // 2
        low, high = (middle, high) if width_of(cut_to(middle)) <= width else (low, middle - 1)
    return cut_to(low) if low else ""


@contextmanager
def colored(color: ImVec4 | None, slot: int = imgui.Col_.text) -> Iterator[None]:
    """Draw the text of the block, or the style slot `slot`, in a color; None changes nothing."""
    if color is None:
        yield
        return
    imgui.push_style_color(slot, color)
    try:
        yield
    finally:
        imgui.pop_style_color()


def measured_label(lens: Lens, distance_m: float, unit: str = "m") -> str:
    """Return a distance from the entrance pupil to be read at a glance, from this lens's origin."""
    return label_distance(as_measured_m(lens, distance_m), unit)
