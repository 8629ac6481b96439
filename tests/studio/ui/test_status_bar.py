"""The status bar: readout, messages and the progress of an export side by side."""

import webbrowser
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from imgui_bundle import imgui

from heatlens.core.base.messages import Messages, Problem
from heatlens.deliver.farm.export_place import ExportPlace, Where
from heatlens.deliver.farm.export_process import ExportState
from heatlens.studio.ui.texts import fit_text
from heatlens.studio.ui.work_bar import export_title, export_words
from support.session_files import POST

K = imgui.Key


@pytest.fixture
def exporting(gui):
    """Yield a window with the state of an export in progress."""
    run = gui.session.files.exports.run
    run.state = ExportState(
        "export to a", done_frames=12, frames=100, remaining_s=30.0, output="/tmp/a.exr"
    )
    yield gui
    run.state, gui.ui.asks_to_quit = None, False


def test_status_message_stands_beside_the_readout(gui):
    gui.move(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    gui.session.messages.notify("Something was said.")
    gui.drawn.clear()
    gui.frame(2)
    readout, message = gui.rect("readout"), gui.rect("message")
    assert readout[2] < message[0] and abs(readout[1] - message[1]) < 1


def test_status_message_is_whole_and_the_readout_is_shortened(gui, exporting):
    gui.move(gui.at_picture(POST[0] + 0.5, POST[1] + 0.5))
    message_text = "Look B is kept. Ctrl+2 returns to it."
    gui.session.messages.notify(message_text)
    gui.frame(2)
    gui.drawn.clear()
    gui.frame(2)
    readout, message = gui.rect("readout"), gui.rect("message")
    assert message[2] - message[0] == pytest.approx(imgui.calc_text_size(message_text).x, abs=1.0)
    assert readout[2] < message[0] and message[2] < gui.rect("export progress")[0]


def test_messages_know_problems_from_reports():
    messages = Messages()
    for sentence, is_problem in (("Saved.", False), (Problem("Not saved."), True), ("B.", False)):
        messages.notify(sentence)
        assert messages.is_problem is is_problem


def test_problem_stands_over_the_picture_until_it_is_hidden(gui):
    for sentence in (Problem("Not saved."), "Saved."):
        gui.session.messages.notify(sentence)
        gui.drawn.clear()
        gui.frame(2)
        _, top, _, bottom = gui.rect("message")
        is_over_picture = bottom < gui.rect("focus bar")[1]
        assert top > gui.size[1] / 3 and is_over_picture is isinstance(sentence, Problem)
    gui.session.messages.notify(Problem("Not saved."))
    gui.frame(2)
    gui.click(gui.middle("hide problem"))
    assert not gui.session.messages.text


def test_problem_is_told_once(gui, tmp_path):
    """A notice with its sentence takes its place, and leaves none of it when answered."""
    broken = tmp_path / "broken.exr"
    broken.write_bytes(b"no exr")
    gui.session.files.commands.open(str(broken))
    gui.until(lambda: gui.session.messages.is_problem and gui.session.messages.text, "the refusal")
    gui.drawn.clear()
    gui.frame(3)
    assert "notice OK" in gui.drawn and "message" not in gui.drawn
    for is_bare in (True, False):  # the picture alone has no notices
        gui.ui.is_bare = is_bare
        gui.drawn.clear()
        gui.frame(3)
        assert ("message" in gui.drawn) is is_bare is not ("notice OK" in gui.drawn)
    gui.click(gui.middle("notice OK"))
    gui.frame(2)
    assert "message" not in gui.drawn and not gui.session.messages.text


@given(text=st.text(max_size=60), width=st.integers(0, 80))
def test_fit_text_cuts_text_to_the_width(text, width):
    shown = fit_text(text, width, width_of=len)
    assert len(shown) <= max(width, 0) or shown == ""
    assert shown == text or shown == "" or text.startswith(shown.removesuffix(" ..."))


def test_export_progress_is_shown_in_status_bar_and_title(exporting):
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


def test_stop_button_of_the_status_bar_cancels_the_export(exporting, monkeypatch):
    cancel_calls: list[bool] = []
    monkeypatch.setattr(
        exporting.session.files.exports.run, "cancel", lambda: cancel_calls.append(True)
    )
    exporting.frame(2)
    exporting.click(exporting.middle("status Stop"))
    assert cancel_calls == [True]


def test_quit_during_an_export_asks_first(exporting):
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
    ("answer", "cancel_count"),
    [("Leave it to the cluster and close", 0), ("Stop it and close", 1), ("", 0)],
)
def test_quit_during_a_cluster_export_offers_to_leave_it(
    exporting, monkeypatch, answer, cancel_count
):
    """The Enter key leaves the export to the cluster too."""
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
    assert gui.ui.is_over and len(calls) == cancel_count


def test_finished_export_stays_in_the_status_bar_until_closed(exporting, monkeypatch):
    gui, run = exporting, exporting.session.files.exports.run
    gui.frame()
    run.state.code = 0
    gui.frame(2)
    opened_urls: list[str] = []
    monkeypatch.setattr(webbrowser, "open", opened_urls.append)
    gui.click(gui.middle("status Show folder"))
    assert opened_urls == ["file:///tmp"]
    gui.click(gui.middle("status x"))
    gui.drawn.clear()
    gui.frame()
    assert "status Show folder" not in gui.drawn


def test_first_quick_picture_is_explained_until_the_whole_one_is_there(gui, monkeypatch):
    status, preferences = gui.screen.status, gui.session.preferences
    preferences.change(knows_previews=False)
    gui.settled()
    scheduler = type(gui.session.time.scheduler)
    with monkeypatch.context() as patched:
        patched.setattr(scheduler, "is_rendering", True)
        gui.session.lens.commands.focus(2.0)
        gui.frame(2)
        assert status.words(None) == "This is the quick picture; the whole one follows."
        assert not preferences.values.knows_previews
    gui.settled()
    assert "focus" in status.words(None) and preferences.values.knows_previews
    with monkeypatch.context() as patched:
        patched.setattr(scheduler, "is_rendering", True)
        gui.session.lens.commands.focus(3.0)
        gui.frame(2)
        assert "quick picture" not in status.words(None)


def test_status_tells_how_far_the_driver_is_prepared_while_a_process_works(gui, monkeypatch):
    status = gui.screen.status
    usual = status.words(None)
    monkeypatch.setattr(type(gui.session.pictures.builder), "progress", "3 of 12")
    assert "3 of 12" in status.words(None)
    monkeypatch.undo()
    assert status.words(None) == usual
