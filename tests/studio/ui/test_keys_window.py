"""The window of keys: it fits the screen, and lists the keys of the open source."""

import pytest
from imgui_bundle import imgui

from heatlens.studio.ui.keys_window import distribute_in_columns, sections
from support.commands import listed_commands

ALL = listed_commands()


def rows_by_section(has_camera: bool) -> dict[str, tuple[tuple[str, str], ...]]:
    return {section.title: section.rows for section in sections(ALL, has_camera)}


def test_keys_window_lists_every_shortcut_once():
    rows = [row for rows in rows_by_section(has_camera=False).values() for row in rows]
    for action in ALL:
        assert rows.count((action.key, action.name)) == bool(action.key)


def test_keys_window_has_camera_section_only_for_scenes():
    plate, scene = rows_by_section(has_camera=False), rows_by_section(has_camera=True)
    assert set(scene) - set(plate) == {"Mouse in the scene"}
    keys = [key for key, _ in scene["Mouse in the scene"]]
    assert keys == ["right drag", "Ctrl+right drag", "Ctrl+wheel"]


def test_keys_window_lists_the_pan_buttons_of_plates_and_scenes():
    pans = {
        has_camera: [k for k, words in rows_by_section(has_camera)["Mouse"] if "pan" in words]
        for has_camera in (False, True)
    }
    assert pans == {False: ["middle or right drag"], True: ["middle drag"]}


@pytest.mark.parametrize("count", [1, 2, 3])
def test_distribute_in_columns_balances_the_heights_of_all_sections(count):
    all_sections = sections(ALL, has_camera=True)
    columns = distribute_in_columns(all_sections, count)
    assert len(columns) == count and columns[0][0].title == "Mouse"
    assert sorted(s.title for column in columns for s in column) == sorted(
        s.title for s in all_sections
    )
    heights = [sum(2 + len(section.rows) for section in column) for column in columns]
    assert max(heights) - min(heights) <= 0.2 * sum(heights) / count


def test_keys_window_is_centered_with_a_margin(gui):
    em, screen = imgui.get_font_size(), imgui.get_main_viewport()
    gui.key(imgui.Key.f1)
    gui.frame(4)
    x0, y0, x1, y1 = gui.rect("keys window")
    assert abs((x0 + x1) / 2 - screen.get_work_center().x) <= 1
    assert abs((y0 + y1) / 2 - screen.get_work_center().y) <= 1
    assert x0 >= 0.9 * em and x1 <= gui.size[0] - 0.9 * em
    assert y0 >= screen.work_pos.y + 0.9 * em and y1 <= gui.size[1] - 0.9 * em
    assert not imgui.internal.find_window_by_name("Keys").scrollbar_y  # as large as what it tells


@pytest.mark.parametrize("scale", [1.0, 1.5, 2.0])
def test_keys_window_cuts_no_words_at_any_scale(gui, scale):
    gui.session.preferences.change(ui_scales={"": scale})
    gui.key(imgui.Key.f1)
    gui.frame(4)
    window = imgui.internal.find_window_by_name("Keys")
    assert window.content_size.x <= window.work_rect.get_width() + 1
    gui.key(imgui.Key.escape)
    gui.session.preferences.change(ui_scales={})
    gui.frame(4)


def test_keys_window_scrolls_on_a_small_screen(gui):
    em, size = imgui.get_font_size(), gui.io.display_size
    gui.io.display_size = 700, 420
    try:
        gui.key(imgui.Key.f1)
        gui.frame(4)
        x0, y0, x1, y1 = gui.rect("keys window")
        window = imgui.internal.find_window_by_name("Keys")
    finally:
        gui.io.display_size = size
    assert x0 >= 0.9 * em and x1 <= 700 - 0.9 * em
    assert y0 >= imgui.get_main_viewport().work_pos.y and y1 <= 420 - 0.9 * em
    assert window.scrollbar_y and window.content_size.x <= window.work_rect.get_width()
