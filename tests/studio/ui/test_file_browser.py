"""Choosing files inside the window, with a real mouse and real keys."""

import threading
from pathlib import Path

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.media.sequence import folder_walk
from heatlens.studio.settings.preferences import Preferences
from support.exr_files import rgb, write_file
from support.gui import gui_of
from support.patience import PATIENCE_S

K = imgui.Key


def write_plate(path, near=1.0):
    path.parent.mkdir(exist_ok=True)
    depth = np.linspace(near, 9, 24 * 36, dtype=np.float32).reshape(24, 36)
    return write_file(path, rgb(24, 36) | {"Z": depth})


@pytest.fixture
def plates(tmp_path):
    """Return a folder with a still, a sequence and a folder that holds another still."""
    write_plate(tmp_path / "still.exr")
    for frame in (1001, 1002, 1004):
        write_plate(tmp_path / f"shot.{frame}.exr", frame / 1000)
    write_plate(tmp_path / "takes" / "inside.exr")
    return tmp_path


@pytest.fixture
def preferences():
    return Preferences()


@pytest.fixture
def gui(ctx, plates, preferences):
    with gui_of(ctx, plates / "still.exr", preferences) as gui:
        yield gui


def browse(gui, action):
    """Open the file dialog by an action, and wait until its folder is read."""
    gui.do(action)
    wait_for_folder(gui)


def wait_for_folder(gui):
    gui.until(lambda: not gui.ui.dialogs.walk.is_reading, "the folder")
    gui.frame(2)


def double_click(gui, name):
    position = gui.middle(name)
    gui.click(position)
    gui.click(position)


def wait_for_plate(gui, path):
    gui.until(lambda: gui.session.source.plate.path == Path(path), f"the plate {path}")
    assert not gui.ui.dialogs.is_open


def shown_folder(gui):
    return gui.ui.dialogs.walk.typed_path


# Opening


def test_double_click_opens_a_sequence_as_one(gui, plates, preferences):
    browse(gui, "Open...")
    double_click(gui, "file shot.####.exr")
    wait_for_plate(gui, plates / "shot.1001.exr")
    assert gui.session.source.opened.cache.sequence.present == (1001, 1002, 1004)
    assert preferences.values.recent[0] == str(plates / "shot.####.exr")


def test_open_button_opens_the_clicked_file(gui, plates):
    browse(gui, "Open...")
    gui.click(gui.middle("browser Open"))  # nothing is chosen yet: a dead button
    assert gui.ui.dialogs.is_open
    gui.click(gui.middle("file shot.####.exr"))
    gui.click(gui.middle("browser Open"))
    wait_for_plate(gui, plates / "shot.1001.exr")


def test_browser_enters_a_folder_and_goes_up_again(gui, plates):
    browse(gui, "Open...")
    double_click(gui, "file takes/")
    wait_for_folder(gui)
    assert shown_folder(gui) == str(plates / "takes")
    gui.click(gui.middle("browser Up"))
    wait_for_folder(gui)
    assert shown_folder(gui) == str(plates)
    gui.key(K.enter)  # the folder one comes from is chosen
    wait_for_folder(gui)
    gui.key(K.backspace)
    wait_for_folder(gui)
    assert shown_folder(gui) == str(plates)


def test_browser_arrow_keys_and_enter_open_a_file(gui, plates):
    browse(gui, "Open...")
    gui.key(K.down_arrow)
    gui.key(K.down_arrow)
    gui.key(K.enter)
    wait_for_plate(gui, plates / "shot.1001.exr")


def test_browser_home_button_shows_the_home_folder(gui, monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path / "takes"))
    browse(gui, "Open...")
    gui.click(gui.middle("browser Home"))
    wait_for_folder(gui)
    assert shown_folder(gui) == str(tmp_path / "takes")


def type_path(gui, text):
    gui.click(gui.middle("browser path"))
    gui.key(K.a, ctrl=True)
    gui.type(text)
    gui.key(K.enter)


@pytest.mark.parametrize(
    "text", ["takes/inside.exr", "{folder}/takes/inside.exr", "takes/../takes"]
)
def test_typed_path_opens_the_file_or_folder(gui, plates, text):
    browse(gui, "Open...")
    type_path(gui, text.format(folder=plates))
    if text.endswith(".exr"):
        wait_for_plate(gui, plates / "takes" / "inside.exr")
    else:
        wait_for_folder(gui)
        assert shown_folder(gui) == str(plates / "takes")


def test_typed_pattern_opens_a_sequence(gui, plates):
    browse(gui, "Open...")
    type_path(gui, "shot.%04d.exr")
    wait_for_plate(gui, plates / "shot.1001.exr")


def test_missing_typed_file_is_reported_and_the_dialog_stays(gui, plates):
    browse(gui, "Open...")
    type_path(gui, "stil.exr")
    wait_for_folder(gui)
    assert (
        "stil.exr" in gui.session.messages.text and "still.exr" in gui.session.messages.text
    )  # a near name
    assert gui.ui.dialogs.is_open and gui.session.source.plate.path.name == "still.exr"
    gui.key(K.escape)
    assert not gui.ui.dialogs.is_open


@pytest.mark.parametrize("text", ["~nouser9/a.exr", "~nouser9", "n" * 400, "still.exr/a.exr", " "])
def test_impossible_typed_path_is_reported(gui, text):
    browse(gui, "Open...")
    type_path(gui, text)
    wait_for_folder(gui)
    assert gui.ui.dialogs.is_open
    assert text.strip() in gui.session.messages.text or text == " "


def test_letters_typed_in_the_browser_run_no_shortcuts(gui):
    browse(gui, "Open...")
    before = gui.session.facts.view
    gui.key(K.d)
    gui.key(K.w)
    gui.key(K.q, ctrl=True)
    assert gui.session.facts.view == before and not gui.ui.is_over


@pytest.mark.parametrize("leave", ["browser Cancel", "escape"])
def test_canceled_browser_opens_and_remembers_nothing(gui, preferences, leave):
    browse(gui, "Open...")
    gui.click(gui.middle("file shot.####.exr"))
    gui.key(K.escape) if leave == "escape" else gui.click(gui.middle(leave))
    gui.frame(3)
    assert not gui.ui.dialogs.is_open and not gui.session.source.opener.opening
    assert preferences.values.folders == {}


def test_browser_remembers_the_last_folder_of_each_purpose(gui, plates, preferences):
    browse(gui, "Open...")
    type_path(gui, "takes/inside.exr")
    wait_for_plate(gui, plates / "takes" / "inside.exr")
    assert preferences.values.folders == {"open": str(plates / "takes")}
    gui.session.files.commands.open(str(plates / "still.exr"))
    wait_for_plate(gui, plates / "still.exr")
    browse(gui, "Open...")
    assert shown_folder(gui) == str(plates / "takes")
    gui.key(K.escape)
    gui.frame(2)
    browse(gui, "Open reference...")
    assert shown_folder(gui) == str(plates)


def test_reference_from_a_sequence_is_the_file_of_the_frame(gui, plates):
    gui.session.files.commands.open(str(plates / "shot.1002.exr"))
    wait_for_plate(gui, plates / "shot.1002.exr")
    browse(gui, "Open reference...")
    double_click(gui, "file shot.####.exr")
    gui.until(lambda: gui.session.facts.reference is not None, "the reference")
    assert gui.session.facts.reference.path == plates / "shot.1002.exr"


# Saving


def test_saved_name_gets_its_suffix_and_its_typed_folder(gui, plates):
    browse(gui, "Save picture...")
    gui.key(K.a, ctrl=True)  # the name has the focus
    gui.type("takes/mine")
    gui.key(K.enter)
    gui.until(lambda: "Saved" in gui.session.messages.text, "the file", 60)
    assert (plates / "takes" / "mine.exr").exists()


def test_save_overwrites_a_file_only_after_the_question(gui, plates):
    before = (plates / "takes" / "inside.exr").read_bytes()
    browse(gui, "Save picture...")
    type_path(gui, "takes/inside.exr")
    wait_for_folder(gui)
    assert gui.ui.dialogs.walk.name == "inside.exr"
    double_click(gui, "browser Save")  # in one place: the second one keeps what is there
    assert gui.ui.dialogs.walk.existing_file is None
    gui.click(gui.middle("browser Save"))
    gui.click(gui.middle("browser Keep it"))
    gui.settled()
    assert gui.ui.dialogs.is_open and not gui.session.pictures.saving.is_busy
    assert (plates / "takes" / "inside.exr").read_bytes() == before
    gui.click(gui.middle("browser Save"))
    gui.click(gui.middle("browser Overwrite"))
    gui.until(lambda: "Saved" in gui.session.messages.text, "the file", 60)
    assert (plates / "takes" / "inside.exr").read_bytes() != before


def test_save_never_overwrites_the_plate(gui, plates):
    before = (plates / "still.exr").read_bytes()
    browse(gui, "Save picture...")
    gui.click(gui.middle("file still.exr"))
    gui.click(gui.middle("browser Save"))
    gui.click(gui.middle("browser Overwrite"))
    gui.until(lambda: "is the plate itself" in gui.session.messages.text, "the refusal", 60)
    assert (plates / "still.exr").read_bytes() == before


# A disk that does not answer


def test_slow_folder_does_not_block_and_the_last_request_counts(gui, plates, monkeypatch):
    answer, real_list_folder = threading.Event(), folder_walk.list_folder

    def list_slowly(folder, *how):
        if folder.name == "takes":
            assert answer.wait(PATIENCE_S)
        return real_list_folder(folder, *how)

    monkeypatch.setattr(folder_walk, "list_folder", list_slowly)
    browse(gui, "Open...")
    double_click(gui, "file takes/")
    gui.frame(5)  # drawn although the folder is not read
    assert gui.ui.dialogs.walk.is_reading and shown_folder(gui) == str(plates)
    gui.click(gui.middle("browser Up"))
    wait_for_folder(gui)
    answer.set()
    gui.frame(5)
    assert shown_folder(gui) == str(plates.parent)
