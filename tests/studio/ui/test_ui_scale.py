"""The scale of the interface: panels keep their size in letters, and the scale is remembered."""

import glfw
import pytest
from imgui_bundle import imgui

from heatlens.studio.ui.devices import units_scale
from heatlens.studio.ui.layout import restore_layout
from heatlens.studio.ui.status_bar import StatusBar

K = imgui.Key


def column_em(gui) -> float:
    """Return the width of the column of panels in letters (em)."""
    return imgui.internal.find_window_by_name("Lens").size.x / gui.ui.scale.em


def test_scale_keys_resize_panels_and_remember_the_scale(gui):
    gui.frame(3)
    em, width_em = gui.ui.scale.em, column_em(gui)
    for _ in range(2):
        gui.key(K.equal, ctrl=True)
    gui.frame(4)
    assert gui.ui.scale.em == 1.25 * em
    assert column_em(gui) == pytest.approx(width_em, rel=0.05)
    assert gui.session.preferences.values.ui_scales == {"": 1.25}
    for _ in range(2):
        gui.key(K.minus, ctrl=True)
    gui.frame(4)
    assert gui.ui.scale.em == em and column_em(gui) == pytest.approx(width_em, rel=0.02)
    assert gui.session.preferences.values.ui_scales == {}


@pytest.mark.parametrize(("key", "scale"), [(K.enter, 2.0), (K.escape, 1.0)])
def test_large_screen_of_unknown_scale_asks_once_how_large_text_should_be(gui, key, scale):
    gui.ui.scale.screen_width_px = 3840
    gui.frame(3)
    assert "scale Twice as large" in gui.drawn
    gui.key(key)
    gui.frame(3)
    assert gui.session.preferences.values.ui_scales == {"": scale}
    gui.drawn.clear()
    gui.frame(3)
    assert "scale As it is" not in gui.drawn and gui.ui.scale.user_scale == scale
    gui.ui.scale.screen_width_px = 0
    gui.session.preferences.change(ui_scales={})
    gui.frame(4)


def style_values(style: imgui.Style) -> dict[str, object]:
    """Return all numbers of a style by name."""
    values = {name: getattr(style, name) for name in dir(style) if not name.startswith("__")}
    pairs = {name: (value.x, value.y) for name, value in values.items() if hasattr(value, "x")}
    numbers = {name: v for name, v in values.items() if isinstance(v, int | float)}
    return pairs | numbers


def test_style_of_a_scale_does_not_depend_on_earlier_scales(gui):
    styles = []
    for steps in ((2.0,), (1.25, 3.0, 0.75, 2.0)):
        for scale in steps:
            gui.session.preferences.change(ui_scales={"": scale})
            gui.frame()
        styles.append(style_values(imgui.get_style()))
    assert styles[0] == styles[1] and styles[0]["_main_scale"] == 2.0
    gui.session.preferences.change(ui_scales={})
    gui.frame(4)


@pytest.mark.parametrize("scale", [1.0, 1.5, 2.0])
def test_panels_cut_no_words_at_large_scales(gui, scale, monkeypatch):
    monkeypatch.setattr(StatusBar, "words", lambda *_: "a hint that is as long as any " * 6)
    gui.session.pictures.looks.keep()
    gui.session.time.marks.set_point((50, 32))
    gui.session.messages.clear()
    gui.session.preferences.change(ui_scales={"": scale})
    gui.frame(4)
    gui.drawn.clear()
    gui.frame(2)
    assert gui.rect("readout")[2] < gui.rect("sides")[0]  # side by side at the lower edge
    for panel, words in (
        ("Lens", "hyperfocal"),
        ("Looks", "lens of look A"),
        ("Marks", "delete A"),
        ("Source", "plate because"),
    ):
        imgui.set_window_focus(panel)
        gui.frame(3)
        window = imgui.internal.find_window_by_name(panel)
        assert gui.rect(words)[2] <= window.work_rect.max.x + 1, words
    imgui.set_window_focus("Lens")
    gui.session.preferences.change(ui_scales={})
    gui.frame(4)


def test_restored_layout_of_another_screen_keeps_its_size_in_letters(gui):
    gui.frame(3)
    layout, em, width_em = imgui.save_ini_settings_to_memory(), gui.ui.scale.em, column_em(gui)
    gui.ui.scale.screen_scale = 1.5
    gui.ui.scale.apply()
    restore_layout(gui.ui, layout, em)
    gui.frame(4)
    assert column_em(gui) == pytest.approx(width_em, rel=0.05)
    gui.ui.scale.screen_scale = 1.0
    gui.frame(3)


@pytest.mark.parametrize(
    ("platform", "scale"),
    [
        (glfw.PLATFORM_X11, 2.0),
        (glfw.PLATFORM_WIN32, 2.0),
        (glfw.PLATFORM_WAYLAND, 1.0),
        (glfw.PLATFORM_COCOA, 1.0),
    ],
)
def test_interface_grows_only_where_screen_units_are_pixels(monkeypatch, platform, scale):
    monkeypatch.setattr(glfw, "get_platform", lambda: platform)
    monkeypatch.setattr(glfw, "get_window_content_scale", lambda _: (2.0, 2.0))
    assert units_scale(None) == scale
