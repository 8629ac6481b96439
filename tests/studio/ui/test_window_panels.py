"""The layout of panels in a window of 1280x800: all tabs are visible, and rows are even."""

from itertools import pairwise

import pytest
from imgui_bundle import imgui

from heatlens.studio.ui.layout import lists_all_panels


def window(name: str) -> imgui.internal.Window:
    return imgui.internal.find_window_by_name(name)


@pytest.mark.parametrize("name", ["Lens", "Display", "Source"])
def test_all_tabs_fit_beside_the_front_tab(gui, name):
    imgui.set_window_focus(name)
    gui.frame(3)
    bar = window(name).dock_node.tab_bar
    assert bar.width_all_tabs <= bar.bar_rect.get_width()


def test_reel_strip_is_hidden_for_a_plate(gui):
    assert gui.session.files.reel.reel is None
    reel = window("Reel strip")
    assert reel is None or not reel.active
    # A layout that did not know it would be thrown away.
    assert lists_all_panels(imgui.save_ini_settings_to_memory(), gui.ui.panels)


def test_overlay_buttons_stand_in_even_rows(gui):
    imgui.set_window_focus("Display")
    gui.frame(3)
    names = ("off", "zones", "plane", "blur", "depth", "layers")
    rectangles = [gui.rect(f"overlay {name}") for name in names]
    tops, lefts = [place[1] for place in rectangles], [place[0] for place in rectangles]
    assert tops == [tops[0]] * 3 + [tops[3]] * 3 and tops[3] > tops[0]
    assert lefts[:3] == lefts[3:]


def test_comparison_controls_are_visible_without_scrolling(gui):
    imgui.set_window_focus("Display")
    gui.frame(3)
    panel = window("Display")
    assert not panel.scrollbar_y
    for name in ("compare off", "compare difference", "compare with"):
        x0, _, x1, y1 = gui.rect(name)
        assert panel.pos.x <= x0 and x1 <= panel.pos.x + panel.size.x
        assert y1 <= panel.pos.y + panel.size.y


def test_kit_and_opening_are_visible_below_the_focus(gui):
    panel = imgui.internal.find_window_by_name("Lens")
    imgui.set_window_focus("Lens")
    imgui.internal.set_scroll_y(panel, 0.0)
    gui.frame(3)
    end = panel.pos.y + panel.size.y
    rectangles = [
        gui.rect(name) for name in ("distance", "f-stop", "focal length", "kit", "opening")
    ]
    assert all(low[3] <= high[1] for low, high in pairwise(rectangles)) and rectangles[-1][3] <= end
    assert "sensor width" not in gui.drawn or gui.rect("sensor width")[1] > rectangles[-1][3]
