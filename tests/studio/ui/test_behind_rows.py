"""Pictures behind a plate, chosen in the Source panel."""

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.media.documents.shot_file import read_shot
from heatlens.media.sequence.folder_list import list_folder
from heatlens.media.sequence.folder_walk import ChosenFile
from heatlens.studio.settings.file_purposes import PURPOSES
from support.gui import gui_of
from support.plates import room
from support.session_files import HEIGHT, WIDTH, room_file, write_plate

SIZE = (1280, 1700)  # tall: every control of the panel is in sight


def wall_file(path, metres=9.0):
    color, _ = room(WIDTH, HEIGHT)
    wall = np.full((HEIGHT, WIDTH), metres, np.float32)
    return write_plate(path, np.full_like(color, 0.25), Z=wall)


@pytest.fixture
def gui(ctx, tmp_path):
    with gui_of(ctx, room_file(tmp_path / "room.exr"), size=SIZE) as gui:
        imgui.set_window_focus("Source")
        gui.frame(3)
        yield gui


def add_picture_behind(gui, path):
    gui.session.files.commands.apply_choice(ChosenFile(PURPOSES["behind"], path))
    wait_for_answer(gui)


def wait_for_answer(gui):
    gui.until(lambda: not gui.session.source.opener.opening, "an answer", 90.0)
    gui.drawn.clear()
    gui.frame(3)


def test_picture_behind_is_added_reported_saved_and_removed(gui, tmp_path):
    wall = wall_file(tmp_path / "wall.exr")
    add_picture_behind(gui, wall)
    plate, (report,) = gui.session.source.plate, gui.session.source.plate.behind
    assert (
        gui.session.facts.shot.plate_options.behind == (str(wall),)
        and f"behind {wall}" in gui.drawn
    )
    assert report.words.startswith("lies behind") and plate.fragments is not None
    gui.session.files.documents.save_as(tmp_path / "a.heatlens.json")
    gui.until(lambda: (tmp_path / "a.heatlens.json").exists(), "the shot")
    assert read_shot(tmp_path / "a.heatlens.json").plate_options.behind == (str(wall),)
    gui.click(gui.middle(f"remove {wall}"))
    wait_for_answer(gui)
    assert gui.session.source.plate.fragments is None
    gui.rest()
    gui.do("Undo")
    gui.until(lambda: gui.session.source.plate.fragments is not None, "what lies behind", 90.0)


def test_picture_behind_without_depth_is_refused_beside_its_field(gui, tmp_path):
    plate = gui.session.source.plate
    add_picture_behind(gui, write_plate(tmp_path / "flat.exr", plate.color))
    assert "flat.exr has no depth" in gui.session.files.commands.reading.problem
    _, y0, _, y1 = gui.rect("behind problem")
    assert y1 - y0 > 10 and gui.rect("Add clean plate")[1] >= y1
    assert gui.session.source.plate is plate and gui.session.facts.shot.plate_options.behind == ()


def test_add_picture_behind_button_opens_the_file_dialog(gui):
    gui.click(gui.middle("Add clean plate"))
    gui.frame(2)
    assert gui.ui.dialogs.walk.purpose is PURPOSES["behind"]


def test_still_takes_the_first_file_of_a_sequence_behind_it(gui, tmp_path):
    for frame in (1, 2):
        wall_file(tmp_path / f"wall.{frame:04}.exr")
    entries = list_folder(tmp_path, (".exr",)).entries
    entry = next(entry for entry in entries if entry.name.startswith("wall"))
    gui.session.files.commands.apply_choice(ChosenFile(PURPOSES["behind"], entry.path, entry))
    wait_for_answer(gui)
    assert gui.session.facts.shot.plate_options.behind == (str(tmp_path / "wall.0001.exr"),)
