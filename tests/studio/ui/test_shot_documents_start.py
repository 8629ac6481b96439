"""Shots at the start of the program: after a crash, after viewing only, and from a file."""

from dataclasses import replace

from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.shot_file import autosave_path, unnamed_path, write_shot
from heatlens.studio.settings.preferences import Preferences
from support.gui import gui_of
from support.sequences import sequence_files
from support.session_files import LENS, QUICK, room_file
from support.shots_of_tests import draw_until_saved, with_keys_and_marks


def test_unnamed_shot_is_recovered_after_a_crash(ctx, tmp_path):
    pattern = sequence_files(tmp_path, 1001, 1003)
    folder = tmp_path / "preferences"
    with gui_of(ctx, pattern, Preferences.load(folder), defocus=QUICK) as gui:
        gui.session.editing.do(with_keys_and_marks(gui.session.facts.shot))
        shot = gui.session.facts.shot
        draw_until_saved(gui)
    assert autosave_path(unnamed_path(folder, pattern)).exists()
    with gui_of(ctx, pattern, Preferences.load(folder), defocus=QUICK) as gui:
        gui.until(lambda: gui.session.files.documents.offer is not None, "the question")
        gui.frame(3)
        gui.click(gui.middle("unsaved Go on with it"))
        gui.frame(2)
        assert gui.session.facts.shot == shot


def test_close_deletes_the_autosave_of_a_plate_without_marks_or_keys(ctx, tmp_path):
    plate, folder = room_file(tmp_path / "room.exr"), tmp_path / "preferences"
    with gui_of(ctx, plate, Preferences.load(folder), defocus=QUICK) as gui:
        gui.click(gui.at_picture(22.5, 50.5))
        gui.rest()
        draw_until_saved(gui)
        assert autosave_path(unnamed_path(folder, str(plate))).exists()
    assert not autosave_path(unnamed_path(folder, str(plate))).exists()


def test_shot_file_opens_at_start_and_lens_options_override_it(ctx, tmp_path):
    shot = Shot(replace(LENS, f_stop=4.0), QUICK, sequence_files(tmp_path, 1001, 1003))
    path = tmp_path / "pull.heatlens.json"
    write_shot(path, with_keys_and_marks(shot))
    with gui_of(ctx, path) as gui:
        assert gui.session.facts.shot == with_keys_and_marks(shot)
        assert gui.session.files.documents.path == path
    with gui_of(ctx, path, lens={"squeeze": 2.0}) as gui:
        assert gui.session.facts.shot.lens == replace(shot.lens, squeeze=2.0)
        assert not gui.session.files.documents.is_saved
