"""Every setting of every panel is found in the palette by the label beside its control."""

from collections.abc import Iterator
from dataclasses import replace

import pytest
from imgui_bundle import imgui

from heatlens.core.model.shot.settings import Method
from heatlens.core.model.view.guides import Guides
from heatlens.core.model.view.view import Compare
from heatlens.render.gpu.device import Device
from heatlens.studio.ui import widgets
from heatlens.studio.ui.palette import found, matches
from heatlens.studio.ui.setting_places import SETTINGS
from support.gui import Gui, gui_of
from support.session_files import QUICK, room_file, write_scene

K = imgui.Key


@pytest.fixture(params=["plate", "scene"])
def gui(ctx: Device, tmp_path, request) -> Iterator[Gui]:
    is_scene = request.param == "scene"
    made = write_scene(tmp_path / "a.glb") if is_scene else room_file(tmp_path / "a.exr")
    with gui_of(ctx, made, defocus=QUICK, size=(1280, 2400)) as gui:  # all is in sight
        yield gui


@pytest.fixture
def drawn(monkeypatch) -> dict[str, set[str]]:
    """Return the labels drawn beside controls, by the name of their window."""
    found: dict[str, set[str]] = {}

    def listened(function):
        def heard(words, *others, **keywords):
            window = imgui.internal.get_current_window().name
            found.setdefault(window, set()).add(words)
            return function(words, *others, **keywords)

        return heard

    monkeypatch.setattr(widgets, "label", listened(widgets.label))
    monkeypatch.setattr(imgui, "checkbox", listened(imgui.checkbox))
    monkeypatch.setattr(widgets, "folded_header", lambda *_: True)
    monkeypatch.setattr(imgui, "collapsing_header", lambda *_: True)
    return found


def test_every_label_of_the_panels_is_in_the_settings_list(gui, drawn):
    session = gui.session
    lens = replace(session.facts.lens, blades=6, cat_eye=0.5)  # which opens its part of the panel
    session.editing.edit_lens(lens)
    guides = Guides(aspect=2.2, desqueeze=1.7)
    session.pictures.commands.change(compare=Compare.DIFFERENCE, guides=guides)
    if session.facts.has_camera:
        defocus = replace(QUICK, method=Method.ACCUMULATION, views=4)
        session.editing.do(replace(session.facts.shot, defocus=defocus))
    for panel in gui.ui.panels:
        imgui.set_window_focus(panel)
        gui.frame(2)
    panels = {panel: words for panel, words in drawn.items() if panel in gui.ui.panels}
    assert panels.keys() >= {"Lens", "Display", "Export", "Source", "Marks"}
    missing = {panel: words - set(SETTINGS[panel]) for panel, words in panels.items()}
    assert not any(missing.values()), missing


SEARCH_WORDS = (
    *("theme light", "theme dark", "matte 2.39", "desqueeze 1.33", "peaking magenta", "thirds"),
    *("overlay zones", "guides contrast", "guides opacity", "cat's eye", "timecode", "clip scene"),
    *("matte never", "matte frame", "clean plate", "bokeh blades", "DoF", "plan", "speed"),
    *("larger interface", "second window names", "film back", "quality film", "close focus"),
)


def test_palette_finds_something_for_usual_search_words(gui):
    all_entries = [*gui.screen.commands, *gui.screen.settings()]
    for words in SEARCH_WORDS:
        assert [action.name for action in all_entries if matches(action, words)], words


def test_palette_begins_with_what_the_words_mean_first(gui):
    all_entries = [*gui.screen.commands, *gui.screen.settings()]
    for words, first in {
        "matte": "flat depth",
        "aperture": "f-stop",
        "rack focus": "Pull focus...",
        "plan": "Plan",
        "letterbox": "Frame mask 2.39",
        "bokeh": "bokeh",
    }.items():
        commands = found(all_entries, words)
        assert commands[0].name == first
        assert set(commands) == {command for command in all_entries if matches(command, words)}


def test_found_setting_is_shown_and_highlighted_until_the_next_click(gui):
    gui.ui.panels["Display"] = False
    gui.frame(2)
    gui.key(K.p, ctrl=True, shift=True)
    gui.type("guides frame mask")
    gui.key(K.enter)
    gui.frame(3)
    assert gui.ui.panels["Display"] and "frame mask" in gui.drawn
    x0, y0, _, y1 = (round(value) for value in gui.rect("frame mask"))
    label_area = slice(y0, y1), slice(x0 - 90, x0 - 4)
    lit_pixels = gui.screenshot()[label_area].astype(int)
    gui.click(gui.middle("picture"))
    gui.frame(2)
    plain_pixels = gui.screenshot()[label_area].astype(int)

    def color_range(pixels) -> int:
        return (pixels.max(axis=2) - pixels.min(axis=2)).max()

    assert color_range(lit_pixels) > 60 > 10 > color_range(plain_pixels)
