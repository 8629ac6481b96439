"""The window of keys: all of it on the screen, and true of what is open."""

import pytest
from imgui_bundle import imgui

from heatlens.studio.ui.keys_window import in_columns, sections
from support.commands import listed_commands

ALL = listed_commands()


def told(has_camera: bool) -> dict[str, tuple[tuple[str, str], ...]]:
    return {section.title: section.rows for section in sections(ALL, has_camera)}


def test_every_shortcut_is_told_once():
    rows = [row for rows in told(False).values() for row in rows]
    for action in ALL:
        assert rows.count((action.key, action.name)) == bool(action.key)


def test_the_camera_is_told_of_where_there_is_one():
    plate, scene = told(False), told(True)
    assert set(scene) - set(plate) == {"Mouse in the scene"}
    keys = [key for key, _ in scene["Mouse in the scene"]]
    assert keys == ["right drag", "Ctrl+right drag", "Ctrl+wheel"]


def test_what_pans_is_true_of_plates_and_of_scenes():
    pans = {has: [k for k, what in told(has)["Mouse"] if "pan" in what] for has in (False, True)}
    assert pans == {False: ["middle or right drag"], True: ["middle drag"]}


@pytest.mark.parametrize("count", [1, 2, 3])
def test_columns_hold_every_section_and_are_about_as_high(count):
    found = sections(ALL, True)
    columns = in_columns(found, count)
    assert len(columns) == count and columns[0][0].title == "Mouse"
    assert sorted(s.title for column in columns for s in column) == sorted(s.title for s in found)
    heights = [sum(2 + len(section.rows) for section in column) for column in columns]
    assert max(heights) - min(heights) <= 0.2 * sum(heights) / count


def test_it_lies_in_the_middle_of_the_screen_with_room_around(gui):
    em, screen = imgui.get_font_size(), imgui.get_main_viewport()
    gui.key(imgui.Key.slash, shift=True)
    gui.frame(4)
    x0, y0, x1, y1 = gui.rect("keys window")
    assert abs((x0 + x1) / 2 - screen.get_work_center().x) <= 1
    assert abs((y0 + y1) / 2 - screen.get_work_center().y) <= 1
    assert x0 >= 0.9 * em and x1 <= gui.size[0] - 0.9 * em
    assert y0 >= screen.work_pos.y + 0.9 * em and y1 <= gui.size[1] - 0.9 * em
    assert not imgui.internal.find_window_by_name("Keys").scrollbar_y  # as large as what it tells


@pytest.mark.parametrize("scale", [1.0, 1.5, 2.0])
def test_no_words_are_cut_at_the_right(gui, scale):
    gui.session.preferences.change(ui_scales={"": scale})
    gui.key(imgui.Key.slash, shift=True)
    gui.frame(4)
    window = imgui.internal.find_window_by_name("Keys")
    assert window.content_size.x <= window.work_rect.get_width() + 1
    gui.key(imgui.Key.escape)
    gui.session.preferences.change(ui_scales={})
    gui.frame(4)


def test_on_a_small_screen_it_can_be_scrolled(gui):
    em, size = imgui.get_font_size(), gui.io.display_size
    gui.io.display_size = 700, 420
    try:
        gui.key(imgui.Key.slash, shift=True)
        gui.frame(4)
        x0, y0, x1, y1 = gui.rect("keys window")
        window = imgui.internal.find_window_by_name("Keys")
    finally:
        gui.io.display_size = size
    assert x0 >= 0.9 * em and x1 <= 700 - 0.9 * em
    assert y0 >= imgui.get_main_viewport().work_pos.y and y1 <= 420 - 0.9 * em
    assert window.scrollbar_y and window.content_size.x <= window.work_rect.get_width()
