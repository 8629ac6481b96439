"""The interface is drawn larger or smaller, panels keep their size in letters, and it is kept."""

import pytest
from imgui_bundle import imgui

from heatlens.ui.layout import restore_layout

K = imgui.Key


def column_em(gui) -> float:
    """Width of the column of panels in letters."""
    return imgui.internal.find_window_by_name("Lens").size.x / gui.ui.scale.em


def test_panels_grow_with_the_letters_and_come_back(gui):
    gui.frame(3)
    em, wide = gui.ui.scale.em, column_em(gui)
    for _ in range(2):
        gui.key(K.equal, ctrl=True)
    gui.frame(4)
    assert gui.ui.scale.em == 1.25 * em
    assert column_em(gui) == pytest.approx(wide, rel=0.05)
    assert gui.session.preferences.now.ui_scales == {"": 1.25}
    for _ in range(2):
        gui.key(K.minus, ctrl=True)
    gui.frame(4)
    assert gui.ui.scale.em == em and column_em(gui) == pytest.approx(wide, rel=0.02)
    assert gui.session.preferences.now.ui_scales == {}


def test_a_layout_of_another_screen_keeps_its_size_in_letters(gui):
    gui.frame(3)
    layout, em, wide = imgui.save_ini_settings_to_memory(), gui.ui.scale.em, column_em(gui)
    gui.ui.scale.of_screen = 1.5
    gui.ui.scale.apply()
    restore_layout(gui.ui, layout, em)
    gui.frame(4)
    assert column_em(gui) == pytest.approx(wide, rel=0.05)
    gui.ui.scale.of_screen = 1.0
    gui.frame(3)
