"""On a Mac the window calls keys as they are called there."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from unittest.mock import patch

import pytest
from imgui_bundle import imgui

from heatlens.studio.ui import texts
from support.gui import Gui
from support.windows_standin import Partial

_OF_TEXT = ("text", "text_disabled", "text_wrapped", "text_colored", "menu_item", "set_tooltip")


@contextmanager
def noted_words() -> Iterator[list[str]]:
    """Note all words that ImGui is given to draw."""
    noted: list[str] = []

    def noting(function: Callable[..., object]) -> Callable[..., object]:
        def call(*values: object, **named: object) -> object:
            noted.extend(value for value in values if isinstance(value, str))
            return function(*values, **named)

        return call

    with patch.multiple(imgui, **{name: noting(getattr(imgui, name)) for name in _OF_TEXT}):
        yield noted


def open_keys(gui: Gui) -> None:
    gui.key(imgui.Key.f1)


def open_menu(gui: Gui) -> None:
    gui.click(gui.middle("menu File"))


def open_palette(gui: Gui) -> None:
    gui.key(imgui.Key.p, ctrl=True, shift=True)


def ask_for_click(gui: Gui) -> None:
    gui.session.messages.notify("Ctrl+Shift+click on the thing.")


@pytest.mark.parametrize("begin", [open_keys, open_menu, open_palette, ask_for_click])
@pytest.mark.parametrize(("platform", "name"), [("darwin", "Cmd"), ("linux", "Ctrl")])
def test_keys_have_the_names_of_the_system(gui, monkeypatch, begin, platform, name):
    monkeypatch.setattr(texts, "sys", Partial(sys, platform=platform))
    begin(gui)
    with noted_words() as words:
        gui.frame(4)
    assert {found for found in ("Ctrl", "Cmd") if any(found in it for it in words)} == {name}
