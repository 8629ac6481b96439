"""Count from outside what a window offers: its controls, panels and menu items.

The functions of ImGui are wrapped while frames are drawn, so nothing of heatlens takes part.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any
from unittest.mock import patch

from imgui_bundle import imgui

from support.gui import Gui

# What answers a press: buttons, fields, sliders, drop-downs, heads of folds, and areas.
_CONTROLS = (
    *("button", "small_button", "invisible_button", "arrow_button", "image_button"),
    *("checkbox", "radio_button", "begin_combo", "begin_list_box", "collapsing_header"),
    *("tree_node", "tree_node_ex", "selectable", "input_text", "input_text_with_hint"),
    *("input_text_multiline", "input_int", "input_float", "input_double", "slider_int"),
    *("slider_float", "drag_int", "drag_float", "v_slider_float", "combo", "list_box"),
)
_MENU_ITEMS = ("menu_item", "menu_item_simple", "begin_menu")
_MENU_WINDOW = "###Menu_00"  # ImGui's name of an open menu; those inside it are 01 and up
_FRAMES = 3  # until the layout of an opened window rests
_AROUND_THE_COLUMN = ("Picture", "Timeline")


@dataclass
class Counted:
    """What one frame drew: each entry is the panel and the label of a control."""

    enabled: list[tuple[str, str]] = field(default_factory=list)
    disabled: list[tuple[str, str]] = field(default_factory=list)
    panels: list[str] = field(default_factory=list)


def count_frame(gui: Gui) -> Counted:
    """Draw a frame and return what is visible in it."""
    gui.frame(_FRAMES)
    counted, disabled = Counted(), [False]

    def note_control(words: str, _: object) -> None:
        if imgui.is_item_visible():
            panel = imgui.internal.get_current_window().name
            (counted.disabled if any(disabled) else counted.enabled).append((panel, words))

    def note_panel(name: str, _: object) -> None:
        if imgui.is_window_docked() and name not in _AROUND_THE_COLUMN:
            counted.panels.append(name)

    with (
        _listening(_CONTROLS, note_control),
        _listening(("begin",), note_panel),
        _listening(("begin_disabled",), lambda is_disabled, _: disabled.append(is_disabled)),
        _listening(("end_disabled",), lambda *_: disabled.pop()),
    ):
        gui.frame()
    return counted


def count_menu_items(gui: Gui, menus: tuple[str, ...]) -> dict[str, int]:
    """Return how many items each menu has, a submenu and what it holds as one."""
    counts: dict[str, int] = {}
    for menu in menus:
        gui.click(gui.middle(f"menu {menu}"))
        gui.frame(_FRAMES)
        names: list[str] = []

        def note_item(words: str, _: object, names: list[str] = names) -> None:
            if imgui.internal.get_current_window().name.endswith(_MENU_WINDOW):
                names.append(words)

        with _listening(_MENU_ITEMS, note_item):
            gui.frame()
        counts[menu] = len(names) - 1  # without the head of the menu itself
        gui.key(imgui.Key.escape)
    return counts


@contextmanager
def _listening(names: tuple[str, ...], note: Callable[[Any, object], None]) -> Iterator[None]:
    """Call `note` with the label and the answer of each function of ImGui, after it was called."""

    def wrapped(function: Callable[..., object]) -> Callable[..., object]:
        def call(*values: object, **named: object) -> object:
            answer = function(*values, **named)
            note(values[0] if values else "", answer)
            return answer

        return call

    functions = {name: wrapped(getattr(imgui, name)) for name in names if hasattr(imgui, name)}
    with patch.multiple(imgui, **functions):
        yield
