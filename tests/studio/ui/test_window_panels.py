"""How the panels lie in a window of 1280x800: every tab is seen, and no row stands alone."""

from itertools import pairwise

import pytest
from imgui_bundle import imgui

from heatlens.studio.ui.layout import lists_all


def window(name: str) -> imgui.internal.Window:
    return imgui.internal.find_window_by_name(name)


@pytest.mark.parametrize("name", ["Display", "Plate", "Export", "Speed"])
def test_the_tab_in_front_is_seen_beside_all_others(gui, name):
    imgui.set_window_focus(name)
    gui.frame(3)
    bar = window(name).dock_node.tab_bar
    assert bar.width_all_tabs <= bar.bar_rect.get_width()


def test_the_scene_has_a_tab_where_there_is_a_scene(gui):
    assert gui.session.scenes.scene is None
    scene = window("Scene")
    assert scene is None or not scene.active
    # A layout that did not know it would be thrown away.
    assert lists_all(imgui.save_ini_settings_to_memory(), gui.ui.panels)


def test_overlays_stand_in_even_rows(gui):
    imgui.set_window_focus("Display")
    gui.frame(3)
    names = ("off", "zones", "plane", "blur", "depth", "layers")
    places = [gui.rect(f"overlay {name}") for name in names]
    tops, lefts = [place[1] for place in places], [place[0] for place in places]
    assert tops == [tops[0]] * 3 + [tops[3]] * 3 and tops[3] > tops[0]
    assert lefts[:3] == lefts[3:]


def test_what_is_compared_is_seen_without_scrolling(gui):
    imgui.set_window_focus("Display")
    gui.frame(3)
    look = window("Display")
    assert not look.scrollbar_y
    for name in ("compare off", "compare difference", "compare with"):
        x0, _, x1, y1 = gui.rect(name)
        assert look.pos.x <= x0 and x1 <= look.pos.x + look.size.x
        assert y1 <= look.pos.y + look.size.y


def test_kit_and_opening_stand_under_the_focus_without_scrolling(gui):
    panel = imgui.internal.find_window_by_name("Lens")
    imgui.set_window_focus("Lens")
    imgui.internal.set_scroll_y(panel, 0.0)
    gui.frame(3)
    end = panel.pos.y + panel.size.y
    places = [gui.rect(name) for name in ("distance", "f-stop", "focal length", "kit", "opening")]
    assert all(low[3] <= high[1] for low, high in pairwise(places)) and places[-1][3] <= end
    assert "sensor width" not in gui.drawn or gui.rect("sensor width")[1] > places[-1][3]
