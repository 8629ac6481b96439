"""How the panels lie in a window of 1280x800: every tab is seen, and no row stands alone."""

import pytest
from imgui_bundle import imgui

from heatlens.ui.layout import lists_all


def window(name: str) -> imgui.internal.Window:
    return imgui.internal.find_window_by_name(name)


@pytest.mark.parametrize("name", ["Look", "Plate", "Export", "Speed"])
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
    imgui.set_window_focus("Look")
    gui.frame(3)
    names = ("off", "zones", "plane", "coc", "depth", "layers")
    places = [gui.rect(f"overlay {name}") for name in names]
    tops, lefts = [place[1] for place in places], [place[0] for place in places]
    assert tops == [tops[0]] * 3 + [tops[3]] * 3 and tops[3] > tops[0]
    assert lefts[:3] == lefts[3:]


def test_what_is_compared_is_seen_without_scrolling(gui):
    imgui.set_window_focus("Look")
    gui.frame(3)
    look = window("Look")
    assert not look.scrollbar_y
    for name in ("compare off", "compare diff", "B is"):
        x0, _, x1, y1 = gui.rect(name)
        assert look.pos.x <= x0 and x1 <= look.pos.x + look.size.x
        assert y1 <= look.pos.y + look.size.y
