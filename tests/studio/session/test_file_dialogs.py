"""What file dialogs do without a window: folders, names, purposes, and what a choice begins."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from heatlens.core.base.errors import HeatlensError
from heatlens.core.model.depth_words import DepthConvention
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.sequence.folder_list import Entry
from heatlens.media.sequence.folder_walk import ChosenFile, FolderWalk
from heatlens.studio.session.files.plate_reading import _lacks_depth_ends
from heatlens.studio.settings.file_purposes import PURPOSES
from support.evening import (
    FIRST,
    LAST,
    begin_session,
    run_loop_once,
    run_until,
    run_until_settled,
    write_plates,
)
from support.exr_files import write_file
from support.session_files import room_file
from support.tev_peers import wait_until


def begin_walk(folder, key="open", name=""):
    folder_walk = FolderWalk(purpose=PURPOSES[key], folder=folder, name=name, wake=lambda: None)
    read_folder(folder_walk)
    return folder_walk


def read_folder(walk):
    """Wait until the folder of the walk is read; return the chosen file, or None."""
    walk._reader.wait()
    return walk.poll()


@pytest.fixture
def folder(tmp_path) -> Path:
    top = tmp_path / "top"
    (top / "a").mkdir(parents=True)
    (top / "b").mkdir()
    room_file(top / "still.exr", 8, 6)
    for frame in (1, 2):
        room_file(top / f"shot.{frame:04}.exr", 8, 6)
    (top / "words.txt").write_text("no picture")
    return top


def test_folder_walk_lists_folders_first_and_a_sequence_as_one_row(folder):
    folder_walk = begin_walk(folder)
    assert folder_walk.rows[:2] == ["a", "b"] and not folder_walk.is_reading
    entries = [row for row in folder_walk.rows if isinstance(row, Entry)]
    assert [entry.path.name for entry in entries] == ["shot.####.exr", "still.exr"]
    assert (
        folder_walk.row == -1
        and not folder_walk.can_confirm
        and folder_walk.typed_path == str(folder)
    )
    assert folder_walk.confirm() is None
    folder_walk.list_single(is_single=True)
    read_folder(folder_walk)
    assert [entry.name for entry in folder_walk.rows[2:]] == [
        *("shot.0001.exr", "shot.0002.exr", "still.exr")
    ]
    assert folder_walk.is_single


def test_folder_walk_selects_the_left_folder_after_going_up(folder):
    folder_walk = begin_walk(folder)
    folder_walk.select(1)
    assert folder_walk.can_confirm and folder_walk.confirm() is None and folder_walk.is_reading
    read_folder(folder_walk)
    assert (
        folder_walk.typed_path == str(folder / "b")
        and folder_walk.rows == []
        and folder_walk.row == -1
    )
    folder_walk.go("..")
    read_folder(folder_walk)
    assert folder_walk.typed_path == str(folder) and folder_walk.rows[folder_walk.row] == "b"
    folder_walk.go(str(folder.parent.parent))
    read_folder(folder_walk)
    assert folder_walk.row == -1


def test_folder_walk_clamps_chosen_row(folder):
    folder_walk = begin_walk(folder)
    folder_walk.select(99)
    assert folder_walk.row == 3 and folder_walk.confirm().path == folder / "still.exr"
    folder_walk.select(-5)
    assert folder_walk.row == 0
    folder_walk.type_name("x")
    assert folder_walk.row == -1 and not folder_walk.can_confirm  # nothing is saved here


def test_folder_walk_accepts_typed_folder_file_or_pattern(folder):
    folder_walk = begin_walk(folder)
    folder_walk.go("still.exr")
    assert read_folder(folder_walk) == ChosenFile(PURPOSES["open"], folder / "still.exr")
    folder_walk.go("shot.####.exr")
    assert read_folder(folder_walk).path == folder / "shot.####.exr"
    folder_walk.go("missing.exr")
    with pytest.raises(HeatlensError, match="missing"):
        read_folder(folder_walk)
    assert "missing" in folder_walk.problem and folder_walk.poll() is None
    folder_walk.go("a")
    assert folder_walk.problem == "" and read_folder(folder_walk) is None


def test_folder_walk_begins_at_nearest_existing_folder(folder):
    assert begin_walk(folder / "a" / "gone" / "deeper").typed_path == str(folder / "a")


def test_save_walk_adds_suffix_and_asks_before_overwriting(folder):
    folder_walk = begin_walk(folder, "save", "new")
    assert folder_walk.can_confirm and folder_walk.confirm() == ChosenFile(
        PURPOSES["save"], folder / "new.exr"
    )
    folder_walk.type_name(" new.PNG ")
    assert folder_walk.confirm().path == folder / "new.PNG"
    folder_walk.type_name("still")
    assert folder_walk.confirm() is None and folder_walk.existing_file == folder / "still.exr"
    assert folder_walk.overwrite() == ChosenFile(PURPOSES["save"], folder / "still.exr")
    folder_walk.select(2)  # another row: the question is gone, and its name is taken
    assert (
        folder_walk.existing_file is None is folder_walk.overwrite()
        and folder_walk.name == "shot.0001.exr"
    )
    folder_walk.type_name("  ")
    assert not folder_walk.can_confirm and folder_walk.confirm() is None


@pytest.mark.parametrize("is_there", [False, True])
def test_save_walk_confirmed_while_its_folder_is_read_saves_or_asks(folder, is_there):
    name = "still.exr" if is_there else "new.exr"
    folder_walk = FolderWalk(PURPOSES["save"], folder, name, wake=lambda: None)
    assert folder_walk.confirm() is None
    chosen = read_folder(folder_walk)
    path = folder / name
    assert chosen == (None if is_there else ChosenFile(PURPOSES["save"], path))
    assert folder_walk.existing_file == (path if is_there else None)
    folder_walk.go(str(folder))
    assert read_folder(folder_walk) is None


def test_save_walk_splits_typed_path_into_folder_and_name(folder):
    folder_walk = begin_walk(folder, "save", "new")
    folder_walk.go("a/other.exr")
    assert read_folder(folder_walk) is None
    assert folder_walk.typed_path == str(folder / "a") and folder_walk.name == "other.exr"
    assert folder_walk.confirm().path == folder / "a" / "other.exr"


def test_each_dialog_purpose_lists_its_file_suffixes():
    assert {key for key, purpose in PURPOSES.items() if purpose.is_save} == {
        "save",
        "sheet",
        "save shot",
        "save reel",
    }
    for purpose in PURPOSES.values():
        assert purpose.suffixes and all(s == s.lower() and s[0] == "." for s in purpose.suffixes)
    assert PURPOSES["save shot"].suffixes == (".heatlens.json",)


# What a session does with a choice


@pytest.fixture
def files(session):
    return session.files.commands


def test_only_open_may_be_chosen_without_an_open_picture(tmp_path):
    session = begin_session(tmp_path / "preferences")
    try:
        files = session.files.commands
        assert files.may_choose("open") and not session.messages.text
        for key in ("save", "behind", "sheet"):
            session.messages.clear()
            assert not files.may_choose(key) and session.messages.text
        assert files.first_name("save") == "" and files.first_folder("open").is_dir()
        files.reload()
        assert session.source.opener.opening is None
    finally:
        session.close()


def test_dialogs_begin_beside_the_plate_or_in_the_last_folder(session, files, tmp_path):
    assert [key for key in PURPOSES if not files.may_choose(key)] == [
        "save reel"
    ]  # no reel is open
    for key in ("open", "save", "save shot"):
        assert files.first_folder(key) == tmp_path
    assert files.first_name("save") == f"walls.{FIRST}.dof.exr"
    assert files.first_name("sheet") == "walls.pull.html"
    assert files.first_name("save shot") == "walls.heatlens.json"
    other = tmp_path / "other"
    other.mkdir()
    session.preferences.remember_folder("save", other)
    assert files.first_folder("save") == other and files.first_folder("open") == tmp_path
    session.files.documents.save_as(other / "walls.heatlens.json")
    assert files.first_folder("save shot") == other
    run_until_settled(session)


def test_open_dropped_pairs_picture_with_its_depth_file(session, files, tmp_path):
    color = np.full((6, 8), 0.5, np.float32)
    write_file(tmp_path / "hero.exr", {name: color for name in "RGB"})
    write_file(tmp_path / "hero_depth.exr", {"Z": color + 2})
    files.open_dropped([str(tmp_path / "hero_depth.exr"), str(tmp_path / "hero.exr")])
    run_until(
        session, lambda: session.editing.shot.source == str(tmp_path / "hero.exr"), "the picture"
    )
    assert session.editing.shot.plate_options.depth_source == str(tmp_path / "hero_depth.exr")
    files.open_dropped([str(tmp_path / f"walls.{FIRST}.exr"), "a.txt"])
    run_until(session, lambda: "a.txt" in session.messages.text, "the reason")
    assert session.editing.shot.source == str(tmp_path / "hero.exr")


def test_take_opens_plate_adds_plate_behind_or_saves_shot(session, files, tmp_path):
    still = room_file(tmp_path / "still.exr", 8, 6)
    files.apply_choice(ChosenFile(PURPOSES["open"], still))
    run_until(session, lambda: session.editing.shot.source == str(still), "the still")
    assert session.preferences.values.recent[0] == str(still)
    behind = room_file(tmp_path / "behind.exr", 8, 6)
    files.apply_choice(ChosenFile(PURPOSES["behind"], behind))
    run_until(
        session,
        lambda: session.editing.shot.plate_options.behind == (str(behind),),
        "the one behind",
    )
    files.apply_choice(ChosenFile(PURPOSES["behind"], behind))
    assert files.reading.options.behind == (str(behind),)  # once is enough
    files.apply_choice(ChosenFile(PURPOSES["save shot"], tmp_path / "a.heatlens.json"))
    run_until_settled(session)
    assert (tmp_path / "a.heatlens.json").is_file()
    session.editing.do(replace(session.editing.shot, marks=()))
    files.apply_choice(ChosenFile(PURPOSES["shot"], tmp_path / "a.heatlens.json"))
    run_until(session, lambda: session.files.documents.is_saved, "the shot")


def test_take_reads_lens_opening_and_camera_into_the_shot(session, files, tmp_path):
    files.apply_choice(ChosenFile(PURPOSES["opening"], room_file(tmp_path / "heart.exr", 16, 16)))
    run_until(session, lambda: session.facts.lens.aperture_image is not None, "the opening")
    assert "heart.exr" in session.messages.text
    session.editing.undo()
    assert session.facts.lens.aperture_image is None
    table = tmp_path / "lens.csv"
    table.write_text("frame,focal_length_mm,f_stop,focus_distance_m\n1001,35,4,3\n1010,35,4,5\n")
    files.apply_choice(ChosenFile(PURPOSES["camera"], table))
    run_until(session, lambda: session.facts.lens.focal_length_mm == 35.0, "the camera")
    assert "lens.csv" in session.messages.text
    assert session.editing.shot.lens_at(1010).focus_distance_m == pytest.approx(5.0)
    for key, name in (("opening", "words.exr"), ("camera", "words.json")):
        (tmp_path / name).write_text("no file of that kind")
        before = session.editing.shot
        files.apply_choice(ChosenFile(PURPOSES[key], tmp_path / name))
        run_until(session, lambda name=name: name in session.messages.text, "the refusal")
        assert session.editing.shot == before


def test_chosen_plate_options_are_remembered_for_the_folder(session, files, tmp_path):
    reading = files.reading
    chosen = PlateOptions(depth_convention=DepthConvention.DISTANCE, scene_unit_m=0.5)
    assert reading.is_possible and reading.read_options == session.source.opened.options
    session.editing.frame = FIRST + 3
    reading.change(chosen)
    reading.change(chosen)
    run_until(session, lambda: session.source.opened.options == chosen, "the plate")
    assert session.editing.shot.plate_options == chosen and reading.problem == ""
    assert session.source.plate.depth_m.max() == 4.0 and session.editing.frame == FIRST + 3
    assert files.options_for(str(tmp_path / "another.####.exr")) == chosen
    session.editing.undo()
    run_until(session, lambda: session.source.opened.options == PlateOptions(), "the plate before")
    assert reading.options == PlateOptions()


def test_wrong_plate_options_are_reported_and_plate_stays(session, files):
    reading = files.reading
    wrong = PlateOptions(depth_channel="no such channel")
    reading.change(wrong)
    run_until(session, lambda: session.source.opener.failure is not None, "the refusal")
    assert "no such channel" in reading.problem and reading.options == wrong
    assert session.source.opened.options == PlateOptions() == reading.read_options
    ends = PlateOptions(depth_convention=DepthConvention.NORMALIZED)
    reading.change(ends)
    assert session.source.opener.opening is None and "near and far" in reading.problem
    reading.change(replace(ends, near_m=1.0))
    assert "near and far" in reading.problem
    assert _lacks_depth_ends(replace(ends, far_m=1.0)) and not _lacks_depth_ends(PlateOptions())
    reading.change(replace(ends, near_m=1.0, far_m=9.0))
    run_until(session, lambda: session.source.opened.options.far_m == 9.0, "the plate")


def test_shot_of_another_plate_does_not_reread_this_plate(session):
    options = PlateOptions(scene_unit_m=0.01)
    other = replace(session.editing.shot, source="/gone.exr", plate_options=options)
    session.editing.begin(other)
    run_loop_once(session)
    assert not session.source.opener.opening and session.source.opened.options == PlateOptions()


def test_reload_stays_at_the_current_frame(session, files, tmp_path):
    session.time.timeline.go_to(FIRST + 4)
    run_until_settled(session)
    before = session.source.opened
    (tmp_path / f"walls.{LAST}.exr").unlink()
    files.reload()
    run_until(session, lambda: session.source.opened is not before, "it")
    assert session.editing.frame == FIRST + 4
    assert session.time.timeline.frames.last == LAST - 1


def test_reload_keeps_changed_focus(session, files):
    session.lens.commands.focus(3.0)
    session.editing.settle()
    before = session.source.opened
    files.reload()
    run_until(session, lambda: session.source.opened is not before, "it")
    assert session.facts.lens.focus_distance_m == 3.0


# The start screen


def test_start_screen_shows_cards_until_a_picture_is_open(tmp_path):
    session = begin_session(tmp_path / "preferences")
    start = session.files.start_choices
    try:
        assert start.is_shown and start.is_nothing_open
        demo, still, other = start.cards()
        assert (demo.text, other.text) == ("demo", None) and still.picture == "focus_fruit.png"
        assert not start.open_card(other) and session.source.opener.opening is None
        start.leave()
        assert start.is_shown  # there is nothing to go back to
        assert start.open_card(replace(other, text=write_plates(tmp_path)))
        run_until_settled(session)
        assert not start.is_shown and not start.is_nothing_open
        start.show()
        assert start.is_shown and session.time.timeline.playback.direction == 0
        start.leave()
        assert not start.is_shown
    finally:
        session.close()


def test_start_screen_lists_at_most_six_recent_files(tmp_path):
    preferences = tmp_path / "preferences"
    session = begin_session(preferences, "")
    plates = [str(room_file(tmp_path / f"p{number}.exr", 8, 6)) for number in range(8)]
    for plate in plates:
        session.preferences.remember_opened(plate)
    session.preferences.remember_opened("demo")
    start = session.files.start_choices
    try:
        start.show()
        wait_until(lambda: session.poll() or len(start.cards()) == 3 + 6)
        recent = start.cards()[3:]
        assert [card.text for card in recent] == plates[:1:-1]
        assert {card.kind for card in recent} == {"Plate"}
        assert recent[0].title == "p7.exr" and recent[0].words
    finally:
        session.close()


def test_start_screen_shows_when_command_line_file_cannot_be_opened(tmp_path):
    session = begin_session(tmp_path / "preferences", str(tmp_path / "missing.exr"))
    start = session.files.start_choices
    try:
        assert not start.is_shown
        run_until(session, lambda: start.is_shown, "the start screen")
        assert "missing.exr" in session.messages.text
    finally:
        session.close()
