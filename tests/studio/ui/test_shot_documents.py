"""Shots as files, by the menu: saved, opened again, kept beside while not saved, offered again."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from imgui_bundle import imgui

from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.shot_file import autosave_path, read_shot, write_autosave, write_shot
from heatlens.studio.session.files.shot_documents import ShotDocuments
from heatlens.studio.session.settings.preferences import Remembered
from support.gui import Gui
from support.sequences import FIRST
from support.session_files import room_file
from support.shots_of_tests import kept, worked_on
from support.timeline_window import film_window, fresh

K = imgui.Key


@pytest.fixture(scope="module")
def film(session_context, tmp_path_factory) -> Iterator[Gui]:
    with film_window(session_context, tmp_path_factory.mktemp("film")) as gui:
        yield gui


def forget(documents: ShotDocuments) -> None:
    """Reset the documents and autosaves of earlier tests."""
    documents.path = documents.offer = None
    documents._saved = documents._kept = documents._reading = documents._coming = None
    documents._complained = ""


@pytest.fixture
def gui(ctx, film) -> Iterator[Gui]:
    forget(film.session.files.documents)
    film.session.preferences.now, film.session.preferences.path = Remembered(), None
    gui = fresh(film)
    yield gui
    gui.until(lambda: not gui.session.files.documents._writing, "the end of writing")


def edited(gui) -> Shot:
    gui.session.editing.do(worked_on(gui.session.facts.shot))
    gui.frame(2)
    return gui.session.facts.shot


def saved_as(gui, path: Path) -> None:
    """Save with Ctrl+Shift+S, typing the name in the browser."""
    gui.key(K.s, ctrl=True, shift=True)
    gui.frame(3)
    gui.until(lambda: not gui.ui.dialogs.walk.is_reading, "the folder")
    gui.frame(2)
    gui.key(K.a, ctrl=True)
    gui.type(str(path))
    gui.key(K.enter)
    gui.until(lambda: "Saved" in gui.session.messages.text, "the file")


def opened(gui, path: Path) -> None:
    gui.session.files.commands.open(str(path))
    gui.until(lambda: gui.session.files.documents.path == path, "the shot")
    gui.frame(2)


def test_a_shot_that_was_saved_and_opened_again_is_the_same(gui, tmp_path):
    shot = edited(gui)
    path = tmp_path / "pull.heatlens.json"
    saved_as(gui, path)
    assert read_shot(path) == shot and gui.session.files.documents.is_saved
    assert gui.session.files.documents.title == "pull.heatlens.json"
    gui.open(room_file(tmp_path / "still.exr"))
    assert gui.session.files.documents.path is None
    opened(gui, path)
    assert gui.session.facts.shot == shot
    assert gui.session.editing.history.past == ()
    assert gui.session.source.plate.path.name == f"shot.{FIRST}.exr"


def test_saving_again_asks_for_no_name(gui, tmp_path):
    path = tmp_path / "pull.heatlens.json"
    saved_as(gui, path)
    shot = edited(gui)
    assert gui.session.files.documents.title == "pull.heatlens.json *"
    gui.session.messages.clear()
    gui.key(K.s, ctrl=True)
    gui.until(lambda: "Saved" in gui.session.messages.text, "the file")
    assert read_shot(path) == shot and not gui.ui.dialogs.is_open


def test_a_shot_is_chosen_in_the_browser(gui, tmp_path):
    shot = worked_on(gui.session.facts.shot)
    for number in (1, 2):
        write_shot(tmp_path / f"v{number}.heatlens.json", shot)
    gui.session.preferences.looked_in("shot", tmp_path)
    gui.do("Open shot...")
    gui.until(lambda: not gui.ui.dialogs.walk.is_reading, "the folder")
    gui.frame(3)
    at = gui.middle("file v2.heatlens.json")
    gui.click(at)
    gui.click(at)
    gui.until(lambda: gui.session.files.documents.path is not None, "the shot")
    assert gui.session.files.documents.path == tmp_path / "v2.heatlens.json"
    assert gui.session.facts.shot == shot


@pytest.mark.parametrize("answer", ["Recover it", "Discard it"])
def test_after_a_crash_the_unsaved_shot_is_offered(gui, tmp_path, answer):
    path, saved = tmp_path / "pull.heatlens.json", gui.session.facts.shot
    write_shot(path, saved)
    write_autosave(path, worked_on(saved))
    gui.session.files.commands.open(str(path))
    gui.until(lambda: gui.session.files.documents.offer is not None, "the question")
    gui.frame(3)
    gui.key(K.m)  # means nothing while there is a question
    gui.click(gui.middle(f"unsaved {answer}"))
    gui.until(lambda: gui.session.files.documents.path == path, "the shot")
    goes_on = answer == "Recover it"
    assert gui.session.facts.shot == (worked_on(saved) if goes_on else saved)
    assert gui.session.files.documents.is_saved is not goes_on
    kept(gui)
    assert autosave_path(path).exists() is goes_on
    assert read_shot(path) == saved
    assert not imgui.is_popup_open("", imgui.PopupFlags_.any_popup)


def test_an_autosave_that_the_crash_cut_off_is_not_offered(gui, tmp_path):
    path = tmp_path / "pull.heatlens.json"
    write_shot(path, worked_on(gui.session.facts.shot))
    autosave_path(path).write_text('{"heatlens_shot": 1, "le')
    opened(gui, path)
    assert gui.session.files.documents.offer is None and gui.session.files.documents.is_saved
