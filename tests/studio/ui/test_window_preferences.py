"""Preferences that the window restores from one start of the program to the next."""

from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import imgui

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import Ending
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.read import read_plate
from heatlens.studio.settings.preferences import Preferences, PreferenceValues
from heatlens.studio.ui.layout import lists_all_panels, restore_layout
from support.exr_files import rgb, write_file
from support.gui import gui_of
from support.sequences import sequence_files
from support.session_files import QUICK


@pytest.fixture
def plate(tmp_path):
    depth = np.linspace(1, 9, 24 * 36, dtype=np.float32).reshape(24, 36)
    return write_file(tmp_path / "plate.exr", rgb(24, 36) | {"Z": depth})


def test_remembered_near_distance_is_dropped_and_reported(ctx, plate):
    options = PlateOptions(depth_convention="distance", near_m=1.0)
    with pytest.raises(InputError, match="--near"):
        read_plate(plate, options)
    preferences = Preferences(PreferenceValues(plates={str(plate.parent): options}))
    with gui_of(ctx, plate, preferences, defocus=QUICK) as gui:
        assert gui.session.source.opened.options == replace(options, near_m=None)
        assert "near and far distances remembered" in gui.session.messages.text


def test_view_unit_and_hidden_panels_are_restored(ctx, plate):
    preferences = Preferences()
    with gui_of(ctx, plate, preferences, defocus=QUICK) as gui:
        display = gui.session.facts.view.display
        view = gui.session.pictures.color.views(display)[-1]
        imgui.set_window_focus("Display")
        gui.frame(2)
        gui.click(gui.middle("view"))
        gui.click(gui.middle(f"view: {view}"))
        gui.do("Metres or feet")
        gui.do("Looks")
        gui.session.save_preferences(hidden_panels=gui.ui.hidden_panels)
    assert preferences.values.view == view
    with gui_of(ctx, plate, preferences, defocus=QUICK) as gui:
        assert (gui.session.facts.view.display, gui.session.facts.view.view) == (display, view)
        assert gui.session.facts.view.unit == "ft"
        assert [name for name, shown in gui.ui.panels.items() if not shown] == ["Looks"]


def test_playback_ending_and_pace_are_restored(ctx, tmp_path):
    film = sequence_files(tmp_path)
    preferences = Preferences.load(tmp_path / "config")
    with gui_of(ctx, film, preferences, defocus=QUICK) as gui:
        for choice in ("ending: bounce", "pace: real time"):
            gui.frame(30)
            gui.click(gui.middle("more transport"))
            gui.frame(2)
            gui.click(gui.middle(choice.split(":")[0]))
            gui.click(gui.middle(choice))
            gui.key(imgui.Key.escape)
        gui.session.save_preferences(hidden_panels=gui.ui.hidden_panels)
    reloaded = Preferences.load(tmp_path / "config")
    assert (reloaded.values.ending, reloaded.values.every_frame) == (Ending.BOUNCE, False)
    with gui_of(ctx, film, reloaded, defocus=QUICK) as gui:
        assert gui.session.time.timeline.playback.ending is Ending.BOUNCE
        assert not gui.session.time.timeline.playback.is_every_frame


def test_lists_all_panels_accepts_only_layouts_with_every_panel():
    assert lists_all_panels("[Window][Picture]\n\n[Window][Lens]\nPos=1,1\n", ["Lens"])
    assert not lists_all_panels("[Window][Picture]\n[Window][Lens]\n", ["Lens", "Display"])
    assert not lists_all_panels("", ["Lens"])


def test_stored_layout_of_other_panels_is_replaced_with_a_message(ctx, plate):
    with gui_of(ctx, plate, Preferences(), defocus=QUICK) as gui:
        new_layout = imgui.save_ini_settings_to_memory()
        restore_layout(gui.ui, new_layout)
        assert not gui.ui.wants_layout and gui.session.messages.text == ""
        gui.ui.wants_layout = True
        restore_layout(gui.ui, new_layout.replace("[Window][Source]", "[Window][Plate]"))
        assert gui.ui.wants_layout and "other panels" in gui.session.messages.text


def test_missing_recent_files_are_not_shown_but_stay_remembered(ctx, plate):
    preferences = Preferences()
    preferences.remember_opened(str(plate.with_name("gone.exr")))
    with gui_of(ctx, plate, preferences, defocus=QUICK) as gui:
        gui.click(gui.middle("menu File"))
        gui.until(lambda: gui.session.files.recent.existing_names, "the recent files")
        assert gui.session.files.recent.existing_names == (str(plate),)
        assert preferences.values.recent == (str(plate), str(plate.with_name("gone.exr")))


def test_click_on_a_recent_file_opens_it(ctx, plate, tmp_path):
    other = write_file(tmp_path / "other.0001.exr", rgb(24, 36) | {"Z": np.ones((24, 36), "f4")})
    pattern = tmp_path / "other.####.exr"
    preferences = Preferences()
    preferences.remember_opened(str(pattern))
    with gui_of(ctx, plate, preferences, defocus=QUICK) as gui:
        gui.click(gui.middle("menu File"))
        gui.until(lambda: gui.session.files.recent.existing_names, "the recent files")
        gui.frame(2)
        gui.move(gui.middle("menu Open recent"))
        gui.frame(30)
        gui.click(gui.middle("recent other.####.exr"))
        gui.until(lambda: gui.session.source.plate.path == other, "the other plate")
    assert preferences.values.recent[0] == str(pattern)
