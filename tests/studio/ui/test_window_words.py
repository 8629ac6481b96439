"""Texts of the window: readout, title, doubts, and messages that end when no longer true."""

from dataclasses import replace

import pytest
from imgui_bundle import imgui

from heatlens.core.base.messages import Messages, Problem, passing_message
from heatlens.core.model.shot.settings import Quality
from heatlens.studio.ui.panels.rendering_panel import speed_rows
from support.gui import gui_of
from support.sequences import sequence_files
from support.session_files import QUICK

K = imgui.Key


def test_status_bar_shows_hint_and_method_off_the_picture(gui):
    x0, y0, x1, y1 = gui.rect("picture")
    for position in ((x0 + 3, y0 + 3), (x1 - 3, y0 + 3), (x0 + 3, y1 - 3), (x1 - 3, y1 - 3)):
        gui.move(position)
        gui.session.messages.clear()
        gui.drawn.clear()
        gui.frame(2)
        assert {"readout", "sides"} <= gui.drawn.keys()
        assert abs(gui.rect("readout")[1] - gui.rect("sides")[1]) < 2
    for margin in ((-5, -5), (10_000, 3)):  # as the picture tells a pointer beside itself
        assert "F1 shows the keys" in gui.screen.status.words(margin)


@pytest.mark.parametrize(
    ("mods", "does"), [((), True), ((K.mod_alt,), False), ((K.mod_super,), False)]
)
def test_key_with_alt_or_super_runs_no_shortcut(gui, mods, does):
    before = gui.session.facts.view.overlay
    for mod in mods:
        gui.hold(mod)
    gui.key(K.v)
    for mod in mods:
        gui.hold(mod, down=False)
    assert (gui.session.facts.view.overlay is not before) == does


def test_passing_message_ends_when_it_is_no_longer_true():
    messages, facts = Messages(lambda: 0.0), {"is_true": True}
    messages.notify(passing_message("No keys yet.", lambda: facts["is_true"]))
    messages.fade()
    assert messages.text == "No keys yet."
    facts["is_true"] = False
    messages.fade()
    assert messages.text == ""
    messages.notify(Problem("This stays."))
    messages.fade()
    assert messages.text == "This stays."


def test_impossible_aperture_shows_a_doubt_beside_the_f_stop(gui):
    gui.session.editing.edit_lens(replace(gui.session.facts.lens, f_stop=0.1))
    gui.drawn.clear()
    gui.frame(2)
    assert "doubt about aperture" in gui.drawn
    assert gui.rect("f-stop")[1] < gui.rect("doubt about aperture")[1] < gui.rect("T-stop")[1]


def test_speed_panel_names_the_preview_once(gui, monkeypatch):
    drawn_texts = []
    monkeypatch.setattr(imgui, "text_wrapped", lambda text: drawn_texts.append(text))
    shown = gui.session.pictures.live.output
    assert shown is not None
    for quality, words in ((Quality.PREVIEW, "preview"), (Quality.DRAFT, "preview, draft")):
        settings = replace(shown.settings, quality=quality, proxy=shown.settings.proxy / 2)
        drawn_texts.clear()
        imgui.new_frame()
        imgui.begin("alone")
        preview = replace(shown, settings=settings)
        speed_rows(gui.session.time.speed, 0.0, preview, gui.session.pictures.renderer)
        imgui.end()
        imgui.end_frame()
        assert drawn_texts[0].endswith(f"x{shown.texture.size[1]}, {words}")


def test_title_names_the_sequence_and_marks_unsaved_changes(session_context, tmp_path):
    folder = sequence_files(tmp_path)
    with gui_of(session_context, folder, defocus=QUICK) as gui:
        documents = gui.session.files.documents
        plate = gui.session.facts.plate
        assert plate is not None and documents.window_title == plate.path.parent.name
        gui.session.time.marks.set_here()
        assert documents.window_title.endswith(" *")
        gui.session.editing.undo()
        assert not documents.window_title.endswith("*")


def test_window_draws_until_the_tab_of_a_new_timeline_has_its_width(gui):
    turn = gui.screen.turn
    while turn.begin_due_frame():
        pass
    gui.frame(3)
    while turn.begin_due_frame():
        pass
    gui.screen._had_timeline = not gui.screen._had_timeline
    gui.frame()
    due = 0
    while turn.begin_due_frame():
        due += 1
    assert due >= 2
