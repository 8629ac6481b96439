"""The line under everything: readout, messages and an export side by side."""

import webbrowser
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from imgui_bundle import imgui

from heatlens.studio.session.exports.export_process import ExportState
from heatlens.studio.session.messages import Messages, Problem
from heatlens.studio.session.settings.export_place import ExportPlace, Where
from heatlens.studio.ui.status_bar import export_title, export_words
from heatlens.studio.ui.texts import fitted
from support.session_files import POST

K = imgui.Key


@pytest.fixture
def exporting(gui):
    """Make it look as if an export went on."""
    run = gui.session.files.exports.run
    run.state = ExportState("export to a", done=12, frames=100, left_s=30.0, output="/tmp/a.exr")
    yield gui
    run.state, gui.ui.asks_to_quit = None, False


def test_a_message_stands_beside_the_readout(gui):
    gui.move(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    gui.session.messages.say("Something was said.")
    gui.drawn.clear()
    gui.frame(2)
    readout, message = gui.rect("readout"), gui.rect("message")
    assert readout[2] < message[0] and abs(readout[1] - message[1]) < 1


def test_a_message_is_shown_whole_and_the_readout_is_cut(gui, exporting):
    gui.move(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    said = "Look B is kept. Ctrl+2 returns to it."
    gui.session.messages.say(said)
    gui.frame(2)
    gui.drawn.clear()
    gui.frame(2)
    readout, message = gui.rect("readout"), gui.rect("message")
    assert message[2] - message[0] == pytest.approx(imgui.calc_text_size(said).x, abs=1.0)
    assert readout[2] < message[0] and message[2] < gui.rect("export progress")[0]


def test_what_went_wrong_is_told_from_what_was_done():
    messages = Messages()
    for sentence, is_problem in (("Saved.", False), (Problem("Not saved."), True), ("B.", False)):
        messages.say(sentence)
        assert messages.is_problem is is_problem


def test_a_problem_has_another_colour_than_what_was_done(gui, monkeypatch):
    colors: dict[str, tuple[float, float, float]] = {}
    drawn = imgui.text_colored

    def listened(color, text):
        colors[text] = (color.x, color.y, color.z)
        drawn(color, text)

    monkeypatch.setattr(imgui, "text_colored", listened)
    for sentence in ("Saved.", Problem("Not saved.")):
        gui.session.messages.say(sentence)
        gui.frame()
    assert np.abs(np.subtract(colors["Saved."], colors["Not saved."])).max() > 0.2


@given(text=st.text(max_size=60), width=st.integers(0, 80))
def test_a_message_is_cut_to_its_room(text, width):
    shown = fitted(text, width, width_of=len)
    assert len(shown) <= max(width, 0) or shown == ""
    assert shown == text or shown == "" or text.startswith(shown.removesuffix(" ..."))


def test_an_export_is_told_in_the_status_bar_and_in_the_title(exporting):
    state = exporting.session.files.exports.run.state
    assert export_words(state) == "Exporting 12 of 100, 30 s left"
    assert export_title(state) == "12 % exported, "
    assert (export_words(None), export_title(replace(state, code=0))) == ("", "")
    exporting.drawn.clear()
    exporting.frame(2)
    edge = exporting.size[0]
    for name in ("export progress", "status Stop"):
        x0, _, x1, y1 = exporting.rect(name)
        assert 0 < x0 < x1 < edge and y1 <= exporting.size[1]
    assert exporting.rect("status Stop")[2] <= exporting.rect("sides")[0]


def test_stop_in_the_status_bar_stops_the_export(exporting, monkeypatch):
    stopped: list[bool] = []
    monkeypatch.setattr(exporting.session.files.exports.run, "cancel", lambda: stopped.append(True))
    exporting.frame(2)
    exporting.click(exporting.middle("status Stop"))
    assert stopped == [True]


def test_closing_during_an_export_asks(exporting):
    gui = exporting
    gui.key(K.q, ctrl=True)
    gui.frame(3)
    assert gui.ui.asks_to_quit and not gui.ui.is_over
    gui.click(gui.middle("quit Keep exporting"))
    gui.frame(2)
    assert not gui.ui.asks_to_quit and not gui.ui.is_over
    gui.key(K.q, ctrl=True)
    gui.frame(3)
    gui.click(gui.middle("quit Stop it and close"))
    assert gui.ui.is_over
    gui.ui.is_over = False
    gui.key(K.q, ctrl=True)
    gui.frame(3)
    gui.key(K.escape)
    assert not gui.ui.asks_to_quit and not gui.ui.is_over
    gui.key(K.q, ctrl=True)
    gui.frame(3)
    gui.key(K.enter)
    assert gui.ui.is_over


@pytest.mark.parametrize(
    ("answer", "stopped"),
    [("Leave it to the cluster and close", 0), ("Stop it and close", 1), ("", 0)],
)
def test_closing_during_an_export_on_a_cluster_offers_to_leave_it(
    exporting, monkeypatch, answer, stopped
):
    """Return leaves it too."""
    gui, calls = exporting, []
    run = gui.session.files.exports.run
    monkeypatch.setattr(run, "_place", ExportPlace(Where.CLUSTER))
    monkeypatch.setattr(run, "cancel", lambda: calls.append(True))
    gui.key(K.q, ctrl=True)
    gui.frame(3)
    if answer:
        gui.click(gui.middle(f"quit {answer}"))
    else:
        gui.key(K.enter)
    assert gui.ui.is_over and len(calls) == stopped


def test_the_end_of_an_export_stays_until_it_was_read(exporting, monkeypatch):
    gui, run = exporting, exporting.session.files.exports.run
    gui.frame()
    run.state.code = 0
    gui.frame(2)
    shown: list[str] = []
    monkeypatch.setattr(webbrowser, "open", shown.append)
    gui.click(gui.middle("status Show folder"))
    assert shown == ["file:///tmp"]
    gui.click(gui.middle("status x"))
    gui.drawn.clear()
    gui.frame()
    assert "status Show folder" not in gui.drawn
