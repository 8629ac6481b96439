"""What the window says of itself: readouts, titles, doubts and messages that are true."""

from dataclasses import replace

import pytest
from imgui_bundle import imgui

from heatlens.core.model.shot.settings import Quality
from heatlens.studio.session.messages import Messages, Problem, passing
from heatlens.studio.ui.docked_panels import speed_panel
from support.gui import gui_of
from support.sequences import sequence_files
from support.session_files import QUICK

K = imgui.Key


def test_on_the_margin_of_the_picture_the_bar_shows_a_hint_and_the_method(gui):
    x0, y0, x1, y1 = gui.rect("picture")
    for at in ((x0 + 3, y0 + 3), (x1 - 3, y0 + 3), (x0 + 3, y1 - 3), (x1 - 3, y1 - 3)):
        gui.move(at)
        gui.session.messages.clear()
        gui.drawn.clear()
        gui.frame(2)
        assert {"readout", "sides"} <= gui.drawn.keys()
        assert abs(gui.rect("readout")[1] - gui.rect("sides")[1]) < 2
    for margin in ((-5, -5), (10_000, 3)):  # as the picture tells a pointer beside itself
        assert "? shows the keys" in gui.screen.status.words(margin)


@pytest.mark.parametrize(
    ("mods", "does"), [((), True), ((K.mod_alt,), False), ((K.mod_super,), False)]
)
def test_modifiers_without_a_meaning_leave_a_key_without_one(gui, mods, does):
    before = gui.session.facts.view.overlay
    for mod in mods:
        gui.hold(mod)
    gui.key(K.v)
    for mod in mods:
        gui.hold(mod, False)
    assert (gui.session.facts.view.overlay is not before) == does


def test_a_message_goes_when_it_is_no_longer_true():
    messages, facts = Messages(lambda: 0.0), {"is_true": True}
    messages.say(passing("No keys yet.", lambda: facts["is_true"]))
    messages.fade()
    assert messages.text == "No keys yet."
    facts["is_true"] = False
    messages.fade()
    assert messages.text == ""
    messages.say(Problem("This stays."))
    messages.fade()
    assert messages.text == "This stays."


def test_a_lens_that_nobody_can_make_is_doubted_beside_its_f_stop(gui):
    gui.session.editing.edit_lens(replace(gui.session.facts.lens, f_stop=0.1))
    gui.drawn.clear()
    gui.frame(2)
    assert "doubt about aperture" in gui.drawn
    assert gui.rect("f-stop")[1] < gui.rect("doubt about aperture")[1] < gui.rect("T-stop")[1]


def test_the_speed_panel_says_preview_once(gui, monkeypatch):
    said = []
    monkeypatch.setattr(imgui, "text_wrapped", lambda text: said.append(text))
    shown = gui.session.pictures.live.shown
    assert shown is not None
    for quality, words in ((Quality.PREVIEW, "preview"), (Quality.DRAFT, "preview, draft")):
        settings = replace(shown.settings, quality=quality, proxy=shown.settings.proxy / 2)
        said.clear()
        imgui.new_frame()
        imgui.begin("alone")
        less = replace(shown, settings=settings)
        speed_panel(gui.session.time.speed, 0.0, less, gui.session.pictures.renderer)
        imgui.end()
        imgui.end_frame()
        assert said[0].endswith(f"x{shown.texture.size[1]}, {words}")


def test_the_title_names_the_sequence_and_what_is_not_saved(session_context, tmp_path):
    folder = sequence_files(tmp_path)
    with gui_of(session_context, folder, defocus=QUICK) as gui:
        documents = gui.session.files.documents
        assert "#" in documents.window_title and not documents.window_title.endswith("*")
        gui.session.time.marks.set_here()
        assert documents.window_title.endswith(" *")
        gui.session.editing.undo()
        assert not documents.window_title.endswith("*")
