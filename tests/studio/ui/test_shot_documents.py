"""Shot files by the menu: saved, opened again, autosaved, and offered after a crash."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from imgui_bundle import imgui

from heatlens.core.model.shot.reel import Reel, ReelShot
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.reel_file import write_reel
from heatlens.media.documents.shot_file import autosave_path, read_shot, write_autosave, write_shot
from heatlens.studio.board.controls import FileControl
from heatlens.studio.settings.preferences import PreferenceValues
from support.gui import Gui
from support.sequences import FIRST
from support.session_files import room_file
from support.shots_of_tests import draw_until_saved, with_keys_and_marks
from support.timeline_window import reset_window

K = imgui.Key


def reset_documents(files: FileControl) -> None:
    """Reset the documents and autosaves of earlier tests."""
    documents = files.documents
    documents.path = documents.offer = None
    documents._saved = documents._autosaved_shot = documents._read_future = (
        documents._pending_document
    ) = None
    documents._reported_problem = ""


@pytest.fixture
def gui(ctx, film) -> Iterator[Gui]:
    reset_documents(film.session.files)
    film.session.preferences.values, film.session.preferences.path = PreferenceValues(), None
    gui = reset_window(film)
    yield gui
    gui.until(lambda: not gui.session.files.documents._writes, "the end of writing")


def edit_shot(gui) -> Shot:
    gui.session.editing.do(with_keys_and_marks(gui.session.facts.shot))
    gui.frame(2)
    return gui.session.facts.shot


def save_as(gui, path: Path) -> None:
    """Save with Ctrl+Shift+S, typing the name in the browser."""
    gui.key(K.s, ctrl=True, shift=True)
    gui.frame(3)
    gui.until(lambda: not gui.ui.dialogs.walk.is_reading, "the folder")
    gui.frame(2)
    gui.key(K.a, ctrl=True)
    gui.type(str(path))
    gui.key(K.enter)
    gui.until(lambda: "Saved" in gui.session.messages.text, "the file")


def open_shot(gui, path: Path) -> None:
    gui.session.files.commands.open(str(path))
    gui.until(lambda: gui.session.files.documents.path == path, "the shot")
    gui.frame(2)


def test_saved_and_reopened_shot_is_unchanged(gui, tmp_path):
    shot = edit_shot(gui)
    path = tmp_path / "pull.heatlens.json"
    save_as(gui, path)
    assert read_shot(path) == shot and gui.session.files.documents.is_saved
    assert gui.session.files.documents.title == "pull.heatlens.json"
    gui.open(room_file(tmp_path / "still.exr"))
    assert gui.session.files.documents.path is None
    open_shot(gui, path)
    assert gui.session.facts.shot == shot
    assert gui.session.editing.history.past == ()
    assert gui.session.source.plate.path.name == f"shot.{FIRST}.exr"


def test_ctrl_s_saves_to_the_same_file_without_a_dialog(gui, tmp_path):
    path = tmp_path / "pull.heatlens.json"
    save_as(gui, path)
    shot = edit_shot(gui)
    assert gui.session.files.documents.title == "pull.heatlens.json *"
    gui.session.messages.clear()
    gui.key(K.s, ctrl=True)
    gui.until(lambda: "Saved" in gui.session.messages.text, "the file")
    assert read_shot(path) == shot and not gui.ui.dialogs.is_open


def test_open_shot_by_double_click_in_the_browser(gui, tmp_path):
    shot = with_keys_and_marks(gui.session.facts.shot)
    for number in (1, 2):
        write_shot(tmp_path / f"v{number}.heatlens.json", shot)
    gui.session.preferences.remember_folder("shot", tmp_path)
    gui.do("Open shot...")
    gui.until(lambda: not gui.ui.dialogs.walk.is_reading, "the folder")
    gui.frame(3)
    position = gui.middle("file v2.heatlens.json")
    gui.click(position)
    gui.click(position)
    gui.until(lambda: gui.session.files.documents.path is not None, "the shot")
    assert gui.session.files.documents.path == tmp_path / "v2.heatlens.json"
    assert gui.session.facts.shot == shot


@pytest.mark.parametrize("answer", ["Go on with it", "Open it as saved"])
def test_autosave_is_offered_after_a_crash_and_recovered_or_discarded(gui, tmp_path, answer):
    path, saved = tmp_path / "pull.heatlens.json", gui.session.facts.shot
    write_shot(path, saved)
    write_autosave(path, with_keys_and_marks(saved))
    gui.session.files.commands.open(str(path))
    gui.until(lambda: gui.session.files.documents.offer is not None, "the question")
    gui.frame(3)
    gui.key(K.m)  # means nothing while there is a question
    gui.click(gui.middle(f"unsaved {answer}"))
    gui.until(lambda: gui.session.files.documents.path == path, "the shot")
    is_recovered = answer == "Go on with it"
    assert gui.session.facts.shot == (with_keys_and_marks(saved) if is_recovered else saved)
    assert gui.session.files.documents.is_saved is not is_recovered
    draw_until_saved(gui)
    assert autosave_path(path).exists() is is_recovered
    assert read_shot(path) == saved
    assert not imgui.is_popup_open("", imgui.PopupFlags_.any_popup)


DAMAGED = '{"heatlens_shot": 1, "le'


def wait_for_box(gui, *answers) -> None:
    """Wait for the box about what cannot be read, and check its answers."""
    unreadable = gui.session.files.documents.unreadable
    gui.until(lambda: unreadable.asked, "the reason")
    gui.drawn.clear()
    gui.frame(3)
    names = {name for name in gui.drawn if name.startswith("unreadable ")}
    assert names == {f"unreadable {answer}" for answer in answers}


def test_damaged_shot_asks_and_enter_opens_its_kept_version_unsaved(gui, tmp_path):
    path, documents = tmp_path / "pull.heatlens.json", gui.session.files.documents
    gui.session.preferences.path = tmp_path / "settings" / "preferences.json"
    shot = edit_shot(gui)
    documents.save_as(path)
    draw_until_saved(gui)
    path.write_text(DAMAGED)
    gui.open(room_file(tmp_path / "room.exr"))
    for key in (K.escape, K.enter):
        gui.session.files.commands.open(str(path))
        wait_for_box(gui, "Open the kept one", "Open another...", "Cancel")
        assert str(path) in documents.unreadable.asked.reason
        gui.key(key)
        gui.frame(3)
        assert documents.unreadable.asked is None
        assert gui.session.facts.shot.marks == () or key is K.enter
    gui.until(lambda: documents.path == path, "the version")
    gui.frame(2)
    assert gui.session.facts.shot == shot and documents.title == "pull.heatlens.json *"


def test_damaged_reel_asks_and_enter_opens_the_dialog(gui, tmp_path):
    path = tmp_path / "cut.heatreel.json"
    path.write_text(DAMAGED)
    gui.session.files.commands.open(str(path))
    wait_for_box(gui, "Open another...", "Cancel")
    gui.key(K.enter)
    gui.frame(3)
    assert gui.ui.dialogs.is_open and gui.session.files.documents.unreadable.asked is None
    gui.key(K.escape)
    gui.frame(3)
    write_reel(path, Reel("cut", (ReelShot("s1", "", None, ("its media are missing: /no",)),)))
    gui.session.files.commands.open(str(path))
    wait_for_box(gui, "Look in another folder...", "Open another...", "Cancel")
    gui.key(K.escape)
    gui.session.files.reel.leave()
    gui.frame(3)


def test_damaged_autosave_is_not_offered_but_told(gui, tmp_path):
    path = tmp_path / "pull.heatlens.json"
    write_shot(path, with_keys_and_marks(gui.session.facts.shot))
    autosave_path(path).write_text(DAMAGED)
    open_shot(gui, path)
    assert gui.session.files.documents.offer is None and gui.session.files.documents.is_saved
    wait_for_box(gui, "Go on without")
    gui.key(K.enter)
    gui.frame(3)
    assert gui.session.files.documents.unreadable.asked is None


def test_failed_save_asks_for_another_place_and_enter_opens_the_dialog(gui, tmp_path):
    documents = gui.session.files.documents
    (tmp_path / "file").write_text("a file, and no folder")
    for key in (K.escape, K.enter):
        documents.save_as(tmp_path / "file" / "pull.heatlens.json")
        gui.until(lambda: documents.failed_save, "the reason")
        gui.frame(3)
        assert "failed save Save elsewhere..." in gui.drawn
        gui.key(key)
        gui.frame(3)
        assert not documents.failed_save
        assert gui.ui.dialogs.is_open is (key is K.enter)
        recent = gui.session.preferences.values.recent
        assert not [it for it in recent if it.endswith("file/pull.heatlens.json")]
    gui.key(K.escape)
