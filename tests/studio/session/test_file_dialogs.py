"""What file dialogs do without a window: folders, names, purposes, and what a choice begins."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from heatlens.core.base.errors import HeatlensError
from heatlens.core.model.depth_words import DepthConvention
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.sequence.folder_list import Entry
from heatlens.studio.session.files.file_commands import PURPOSES
from heatlens.studio.session.files.folder_walk import Chosen, FolderWalk
from heatlens.studio.session.files.plate_reading import _lacks_ends
from support.evening import FIRST, LAST, begun, settled, turn, until, write_plates
from support.exr_files import write_file
from support.session_files import room_file
from support.tev_peers import wait_until


def walk(folder, key="open", name=""):
    made = FolderWalk(PURPOSES[key], folder, name, lambda: None)
    polled(made)
    return made


def polled(walk):
    """Return what the folder that is being read brings."""
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


def test_folders_come_first_then_pictures_a_sequence_as_one(folder):
    found = walk(folder)
    assert found.rows[:2] == ["a", "b"] and not found.is_reading
    entries = [row for row in found.rows if isinstance(row, Entry)]
    assert [entry.path.name for entry in entries] == ["shot.####.exr", "still.exr"]
    assert found.row == -1 and not found.can_take and found.typed == str(folder)
    assert found.take() is None
    found.list_single(True)
    polled(found)
    assert [entry.name for entry in found.rows[2:]] == [
        *("shot.0001.exr", "shot.0002.exr", "still.exr")
    ]
    assert found.is_single


def test_a_folder_is_entered_and_left_with_the_row_that_one_came_from(folder):
    found = walk(folder)
    found.choose(1)
    assert found.can_take and found.take() is None and found.is_reading
    polled(found)
    assert found.typed == str(folder / "b") and found.rows == [] and found.row == -1
    found.go("..")
    polled(found)
    assert found.typed == str(folder) and found.rows[found.row] == "b"
    found.go(str(folder.parent.parent))
    polled(found)
    assert found.row == -1


def test_a_row_stays_among_the_rows(folder):
    found = walk(folder)
    found.choose(99)
    assert found.row == 3 and found.take().path == folder / "still.exr"
    found.choose(-5)
    assert found.row == 0
    found.rename("x")
    assert found.row == -1 and not found.can_take  # nothing is saved here


def test_what_is_typed_is_a_folder_a_file_or_a_pattern(folder):
    found = walk(folder)
    found.go("still.exr")
    assert polled(found) == Chosen(PURPOSES["open"], folder / "still.exr")
    found.go("shot.####.exr")
    assert polled(found).path == folder / "shot.####.exr"
    found.go("missing.exr")
    with pytest.raises(HeatlensError, match="missing"):
        polled(found)
    assert "missing" in found.problem and found.poll() is None
    found.go("a")
    assert found.problem == "" and polled(found) is None


def test_a_folder_that_is_gone_begins_at_the_nearest(folder):
    assert walk(folder / "a" / "gone" / "deeper").typed == str(folder / "a")


def test_a_name_to_save_gets_its_suffix_and_asks_before_it_replaces(folder):
    found = walk(folder, "save", "new")
    assert found.can_take and found.take() == Chosen(PURPOSES["save"], folder / "new.exr")
    found.rename(" new.PNG ")
    assert found.take().path == folder / "new.PNG"
    found.rename("still")
    assert found.take() is None and found.overwrites == folder / "still.exr"
    assert found.overwrite() == Chosen(PURPOSES["save"], folder / "still.exr")
    found.choose(2)  # another row: the question is gone, and its name is taken
    assert found.overwrites is None is found.overwrite() and found.name == "shot.0001.exr"
    found.rename("  ")
    assert not found.can_take and found.take() is None


def test_a_typed_path_to_save_is_the_name_in_its_folder(folder):
    found = walk(folder, "save", "new")
    found.go("a/other.exr")
    assert polled(found) is None
    assert found.typed == str(folder / "a") and found.name == "other.exr"
    assert found.take().path == folder / "a" / "other.exr"


def test_each_purpose_says_what_it_takes():
    assert {key for key, one in PURPOSES.items() if one.is_save} == {"save", "sheet", "save shot"}
    for purpose in PURPOSES.values():
        assert purpose.suffixes and all(s == s.lower() and s[0] == "." for s in purpose.suffixes)
    assert PURPOSES["save shot"].suffixes == (".heatlens.json",)


# What a session does with a choice


@pytest.fixture
def files(walls):
    return walls.files.commands


def test_what_can_be_chosen_without_an_open_picture(tmp_path):
    session = begun(tmp_path / "preferences")
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


def test_dialogs_begin_beside_the_plate_and_where_one_was_last(walls, files, tmp_path):
    assert all(map(files.may_choose, PURPOSES))
    for key in ("open", "save", "save shot"):
        assert files.first_folder(key) == tmp_path
    assert files.first_name("save") == f"walls.{FIRST}.dof.exr"
    assert files.first_name("sheet") == "walls.pull.html"
    assert files.first_name("save shot") == "walls.heatlens.json"
    other = tmp_path / "other"
    other.mkdir()
    walls.preferences.looked_in("save", other)
    assert files.first_folder("save") == other and files.first_folder("open") == tmp_path
    walls.files.documents.save_as(other / "walls.heatlens.json")
    assert files.first_folder("save shot") == other
    settled(walls)


def test_a_dropped_picture_takes_its_depth_file_along(walls, files, tmp_path):
    color = np.full((6, 8), 0.5, np.float32)
    write_file(tmp_path / "hero.exr", {name: color for name in "RGB"})
    write_file(tmp_path / "hero_depth.exr", {"Z": color + 2})
    files.open_dropped([str(tmp_path / "hero_depth.exr"), str(tmp_path / "hero.exr")])
    until(walls, lambda: walls.editing.shot.source == str(tmp_path / "hero.exr"), "the picture")
    assert walls.editing.shot.plate_options.depth_source == str(tmp_path / "hero_depth.exr")
    files.open_dropped([str(tmp_path / f"walls.{FIRST}.exr"), "a.txt"])
    until(walls, lambda: "walls" in walls.editing.shot.source, "the first one")


def test_a_choice_opens_adds_or_begins_to_read(walls, files, tmp_path):
    still = room_file(tmp_path / "still.exr", 8, 6)
    files.take(Chosen(PURPOSES["open"], still))
    until(walls, lambda: walls.editing.shot.source == str(still), "the still")
    assert walls.preferences.now.recent[0] == str(still)
    behind = room_file(tmp_path / "behind.exr", 8, 6)
    files.take(Chosen(PURPOSES["behind"], behind))
    until(
        walls, lambda: walls.editing.shot.plate_options.behind == (str(behind),), "the one behind"
    )
    files.take(Chosen(PURPOSES["behind"], behind))
    assert files.reading.options.behind == (str(behind),)  # once is enough
    files.take(Chosen(PURPOSES["save shot"], tmp_path / "a.heatlens.json"))
    settled(walls)
    assert (tmp_path / "a.heatlens.json").is_file()
    walls.editing.do(replace(walls.editing.shot, marks=()))
    files.take(Chosen(PURPOSES["shot"], tmp_path / "a.heatlens.json"))
    until(walls, lambda: walls.files.documents.is_saved, "the shot")


def test_an_opening_and_a_camera_are_read_into_the_shot(walls, files, tmp_path):
    files.take(Chosen(PURPOSES["opening"], room_file(tmp_path / "heart.exr", 16, 16)))
    until(walls, lambda: walls.facts.lens.aperture_image is not None, "the opening")
    assert "heart.exr" in walls.messages.text
    walls.editing.undo()
    assert walls.facts.lens.aperture_image is None
    table = tmp_path / "lens.csv"
    table.write_text("frame,focal_length_mm,f_stop,focus_distance_m\n1001,35,4,3\n1010,35,4,5\n")
    files.take(Chosen(PURPOSES["camera"], table))
    until(walls, lambda: walls.facts.lens.focal_length_mm == 35.0, "the camera")
    assert "lens.csv" in walls.messages.text
    assert walls.editing.shot.lens_at(1010).focus_distance_m == pytest.approx(5.0)
    for key, name in (("opening", "words.exr"), ("camera", "words.json")):
        (tmp_path / name).write_text("no file of that kind")
        before = walls.editing.shot
        files.take(Chosen(PURPOSES[key], tmp_path / name))
        until(walls, lambda name=name: name in walls.messages.text, "the refusal")
        assert walls.editing.shot == before


def test_options_that_a_user_chose_are_remembered_for_the_folder(walls, files, tmp_path):
    reading = files.reading
    chosen = PlateOptions(depth_convention=DepthConvention.DISTANCE, scene_unit_m=0.5)
    assert reading.is_possible and reading.read == walls.source.opened.options
    walls.editing.frame = FIRST + 3
    reading.change(chosen)
    reading.change(chosen)
    until(walls, lambda: walls.source.opened.options == chosen, "the plate")
    assert walls.editing.shot.plate_options == chosen and reading.problem == ""
    assert walls.source.plate.depth_m.max() == 4.0 and walls.editing.frame == FIRST + 3
    assert files.options_for(str(tmp_path / "another.####.exr")) == chosen
    walls.editing.undo()
    until(walls, lambda: walls.source.opened.options == PlateOptions(), "the plate before")
    assert reading.options == PlateOptions()


def test_options_that_cannot_be_read_are_told_and_leave_the_plate(walls, files):
    reading = files.reading
    wrong = PlateOptions(depth_channel="no such channel")
    reading.change(wrong)
    until(walls, lambda: walls.source.opener.refused is not None, "the refusal")
    assert "no such channel" in reading.problem and reading.options == wrong
    assert walls.source.opened.options == PlateOptions() == reading.read
    ends = PlateOptions(depth_convention=DepthConvention.NORMALIZED)
    reading.change(ends)
    assert walls.source.opener.opening is None and "near and far" in reading.problem
    reading.change(replace(ends, near_m=1.0))
    assert "near and far" in reading.problem
    assert _lacks_ends(replace(ends, far_m=1.0)) and not _lacks_ends(PlateOptions())
    reading.change(replace(ends, near_m=1.0, far_m=9.0))
    until(walls, lambda: walls.source.opened.options.far_m == 9.0, "the plate")


def test_a_shot_of_another_plate_leaves_this_one_as_it_is(walls):
    options = PlateOptions(scene_unit_m=0.01)
    other = replace(walls.editing.shot, source="/gone.exr", plate_options=options)
    walls.editing.begin(other)
    turn(walls)
    assert not walls.source.opener.opening and walls.source.opened.options == PlateOptions()


def test_a_file_is_read_again_at_the_same_frame(walls, files, tmp_path):
    walls.time.timeline.go(FIRST + 4)
    settled(walls)
    before = walls.source.opened
    (tmp_path / f"walls.{LAST}.exr").unlink()
    files.reload()
    until(walls, lambda: walls.source.opened is not before, "it")
    assert walls.editing.frame == FIRST + 4
    assert walls.time.timeline.frames.last == LAST - 1


def test_a_reload_keeps_what_was_changed(walls, files):
    walls.lens.commands.focus(3.0)
    walls.editing.settle()
    before = walls.source.opened
    files.reload()
    until(walls, lambda: walls.source.opened is not before, "it")
    assert walls.facts.lens.focus_distance_m == 3.0


# The start screen


def test_the_start_screen_shows_choices_and_leaves_with_the_first_picture(tmp_path):
    session = begun(tmp_path / "preferences")
    start = session.files.start_choices
    try:
        assert start.is_wanted and start.has_nothing
        demo, still, other = start.cards()
        assert (demo.text, other.text) == ("demo", None) and still.picture == "focus_fruit.png"
        assert not start.take(other) and session.source.opener.opening is None
        start.leave()
        assert start.is_wanted  # there is nothing to go back to
        assert start.take(replace(other, text=write_plates(tmp_path)))
        settled(session)
        assert not start.is_wanted and not start.has_nothing
        start.show()
        assert start.is_wanted and session.time.timeline.playback.direction == 0
        start.leave()
        assert not start.is_wanted
    finally:
        session.close()


def test_recent_files_are_at_most_six_and_none_twice(tmp_path):
    preferences = tmp_path / "preferences"
    session = begun(preferences, "")
    plates = [str(room_file(tmp_path / f"p{number}.exr", 8, 6)) for number in range(8)]
    for plate in plates:
        session.preferences.opened(plate)
    session.preferences.opened("demo")
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


def test_a_file_of_the_command_line_that_cannot_be_opened_shows_the_start_screen(tmp_path):
    session = begun(tmp_path / "preferences", str(tmp_path / "missing.exr"))
    start = session.files.start_choices
    try:
        assert not start.is_wanted
        until(session, lambda: start.is_wanted, "the start screen")
        assert "missing.exr" in session.messages.text
    finally:
        session.close()
