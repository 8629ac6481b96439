"""An overlay is one record and one function: a new one defined here works everywhere.

The function is added to a copy of the shaders. No other code of heatlens names it.
"""

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.core.base.errors import InputError
from heatlens.core.model.view import overlays
from heatlens.core.model.view.overlays import OVERLAYS, LegendFacts, Overlay, legend_entries
from heatlens.core.model.view.view import ViewState
from heatlens.studio.board.board import Board
from heatlens.studio.ui.keys_window import sections
from heatlens.studio.ui.palette import matches
from support.gui import gui_of
from support.session_files import QUICK, room_file
from support.shader_copies import edit_shader_file, reloading_copy

VIOLET, LIME = (0.4, 0.2, 0.8), (0.6, 1.0, 0.2)
NEW_OVERLAY = Overlay(
    name="halves",
    words="Halves of the picture",
    label="halves",
    key="Shift+J",
    function="halves_color",
    colors={"OVERLAY_UPPER": VIOLET, "OVERLAY_LOWER": LIME},
    legend=lambda facts: ("upper half", f"lower half, {facts.sharp_px:.0f} px"),
)
FUNCTION = """vec4 halves_color(ivec2 at, float coc) {
    bool is_first = at.y < textureSize(depth_tx, 0).y / 2;
    return vec4(is_first ? OVERLAY_UPPER : OVERLAY_LOWER, 1.0);
}

void main() {"""
FACTS = LegendFacts(-4.0, 4.0, 2.0, (), 1.0, 2.0, "m")


@pytest.fixture
def gui(ctx, tmp_path, monkeypatch):
    """Yield a window of heatlens with the new overlay."""
    monkeypatch.setattr(overlays, "OVERLAYS", (*OVERLAYS, NEW_OVERLAY))
    shaders = reloading_copy(tmp_path / "shaders", monkeypatch)
    edit_shader_file(shaders / "display/overlay.comp.glsl", "void main() {", FUNCTION)
    with gui_of(ctx, room_file(tmp_path / "room.exr"), defocus=QUICK, size=(1280, 2400)) as found:
        yield found


def test_key_draws_the_new_overlay_with_its_colors_and_a_legend(gui):
    assert "legend" not in gui.drawn
    gui.key(imgui.Key.j, shift=True)
    gui.settled()
    assert gui.session.facts.view.overlay == "halves" and "legend" in gui.drawn
    texture = gui.screen.picture.pictures.overlay
    pixels = np.frombuffer(texture.read(), np.uint8).reshape(*texture.size[::-1], 4)
    half = len(pixels) // 2
    for rows, color in ((pixels[:half], VIOLET), (pixels[half:], LIME)):
        assert (rows == [round(255 * value) for value in (*color, 1.0)]).all()
    gui.key(imgui.Key.j, shift=True)
    gui.settled()
    assert gui.session.facts.view.overlay == "none"


def test_panel_menu_palette_and_keys_window_offer_the_new_overlay(gui):
    imgui.set_window_focus("Display")
    gui.frame(2)
    gui.click(gui.middle("overlay halves"))
    assert gui.session.facts.view.overlay == "halves"
    it = next(it for it in gui.screen.commands if it.name == NEW_OVERLAY.words)
    assert (it.menu, it.key, it.is_on()) == ("View", "Shift+J", True)
    matching_settings = [it for it in gui.screen.settings() if matches(it, "overlay halves")]
    assert matches(it, "halves") and [it.name for it in matching_settings] == ["Set overlay halves"]
    rows = [
        row for section in sections(gui.screen.commands, has_camera=False) for row in section.rows
    ]
    assert ("Shift+J", NEW_OVERLAY.words) in rows


def test_legend_of_the_new_overlay_has_its_words_and_colors(monkeypatch):
    monkeypatch.setattr(overlays, "OVERLAYS", (*OVERLAYS, NEW_OVERLAY))
    legend = [(entry.color, entry.words) for entry in legend_entries("halves", FACTS)]
    assert legend == [(VIOLET, "upper half"), (LIME, "lower half, 2 px")]


def test_pages_and_door_offer_the_new_overlay(gui):
    board = Board(gui.session)
    board.check_remote({"do": NEW_OVERLAY.words})
    board.follow({"do": NEW_OVERLAY.words})
    page = board.json_state()
    assert page["view"]["overlay"] == "halves" and page["commands"][NEW_OVERLAY.words] == [True, ""]
    assert [NEW_OVERLAY.words, "Shift+J", "Over the picture"] in page["table"]
    board.follow({"change": "view", "overlay": "none"})
    assert board.facts.view.overlay == "none"
    board.follow({"change": "view", "overlay": "halves"})
    assert board.facts.view.overlay == "halves"


def test_view_state_refuses_an_unknown_overlay_by_name():
    with pytest.raises(InputError, match=r"no overlay 'halves'; there are none, zones, .*layers"):
        ViewState(overlay="halves")
