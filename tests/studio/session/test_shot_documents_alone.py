"""Shot files of a session: opened, saved, autosaved, offered after a crash, and named."""

import hashlib
import os
from dataclasses import replace
from datetime import datetime

import pytest

from heatlens.core.model.marks.marks import DistanceMark
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.shot_file import (
    autosave_path,
    read_shot,
    unnamed_path,
    write_autosave,
    write_shot,
)
from heatlens.studio.board.session import Session
from heatlens.studio.session.shot.shot_store import proposed_name
from heatlens.studio.settings.preferences import Preferences
from heatlens.studio.settings.start import Start
from support.evening import (
    FIRST,
    LAST,
    begin_session,
    run_loop_once,
    run_until,
    run_until_settled,
    write_plates,
)
from support.fake_renderer import FakeRenderer
from support.session_files import LENS, room_file

MARK = DistanceMark("A", 3.0)


@pytest.fixture
def documents(session):
    return session.files.documents


def set_marks(session, *marks):
    session.editing.do(replace(session.editing.shot, marks=marks))


def save_shot(session, path):
    session.files.documents.save_as(path)
    run_until_settled(session)


def test_title_has_a_star_while_changes_are_unsaved(session, documents, tmp_path):
    assert documents.title == documents.shot_name == ""
    folder = session.source.plate.path.parent.name
    assert documents.window_title == folder
    assert not documents.is_saved and not documents.save()
    set_marks(session, MARK)
    assert documents.window_title == f"{folder} *"
    path = tmp_path / "walls.v1.heatlens.json"
    save_shot(session, path)
    assert documents.title == path.name == documents.window_title and documents.is_saved
    assert documents.shot_name == "walls" and documents.proposed_name() == path.name
    assert f"Saved {path}" in session.messages.text
    set_marks(session)
    assert documents.title == f"{path.name} *" == documents.window_title
    session.editing.undo()
    assert documents.title == path.name
    set_marks(session)
    assert documents.save()
    run_until_settled(session)
    assert read_shot(path) == session.editing.shot and documents.is_saved
    assert session.preferences.values.recent[0] == str(path)


def test_shot_file_keeps_frames_of_a_sequence_but_not_of_a_still(session, tmp_path):
    path = tmp_path / "a.heatlens.json"
    save_shot(session, path)
    assert tuple(read_shot(path).frames) == tuple(range(FIRST, LAST + 1))
    still = begin_session(tmp_path / "others", str(room_file(tmp_path / "still.exr", 8, 6)))
    run_until_settled(still)
    save_shot(still, tmp_path / "b.heatlens.json")
    assert read_shot(tmp_path / "b.heatlens.json").frames is None
    assert still.files.documents.proposed_name() == "b.heatlens.json"
    still.close()


@pytest.mark.parametrize(
    ("plate", "is_numbered", "name"),
    [
        ("shot.1001.exr", True, "shot"),
        ("shot_1001.exr", True, "shot"),
        ("shot-12.exr", True, "shot"),
        ("shot12.exr", True, "shot"),
        ("shot.1001.exr", False, "shot.1001"),
        ("1001.exr", True, "1001"),
    ],
)
def test_proposed_name_of_a_shot_comes_from_its_plate(tmp_path, plate, is_numbered, name):
    assert proposed_name(tmp_path / plate, is_numbered) == f"{name}.heatlens.json"


def test_autosave_holds_unsaved_changes_and_is_deleted_on_save(session, documents, tmp_path):
    path = tmp_path / "a.heatlens.json"
    save_shot(session, path)
    assert not autosave_path(path).exists()
    set_marks(session, MARK)
    run_until_settled(session)
    assert read_shot(autosave_path(path)).marks == (MARK,) and read_shot(path).marks == ()
    session.editing.undo()
    run_until_settled(session)
    assert not autosave_path(path).exists()
    session.editing.redo()
    run_until_settled(session)
    documents.save()
    run_until_settled(session)
    assert not autosave_path(path).exists() and not documents.needs_autosave


def test_autosave_waits_for_the_end_of_a_gesture_unless_keep_now(session, documents, tmp_path):
    path = tmp_path / "a.heatlens.json"
    save_shot(session, path)
    session.editing.edit(replace(session.editing.shot, marks=(MARK,)))
    assert documents.needs_autosave
    documents.poll()
    assert not autosave_path(path).exists()  # the hand still moves
    documents.autosave_now()
    assert read_shot(autosave_path(path)).marks == (MARK,)
    written_ns = autosave_path(path).stat().st_mtime_ns
    documents.autosave_now()
    assert autosave_path(path).stat().st_mtime_ns == written_ns  # nothing is new


def test_close_deletes_autosave_of_unnamed_shot_without_marks(tmp_path):
    pattern, preferences = write_plates(tmp_path), tmp_path / "preferences"
    autosave = autosave_path(unnamed_path(preferences, pattern))
    for marks in ((), (MARK,)):
        session = begin_session(preferences, pattern)
        run_until_settled(session)
        session.lens.commands.focus(3.0)
        session.editing.settle()
        set_marks(session, *marks)
        run_until_settled(session)
        assert autosave.exists()
        session.close()
        assert autosave.exists() is bool(marks)


def write_crashed_shot(tmp_path, marks=(MARK,), has_autosave=True):
    """Write a shot file with an autosave of unsaved changes beside it; return its path."""
    pattern, path = write_plates(tmp_path), tmp_path / "a.heatlens.json"
    write_shot(path, Shot(LENS, source=pattern))
    if has_autosave:
        write_autosave(path, replace(read_shot(path), marks=marks))
    return path


def open_with_offer(tmp_path, path):
    """Open the shot file and wait until its unsaved changes are offered; return the session."""
    session = begin_session(tmp_path / "preferences", str(path))
    run_until(session, lambda: session.files.documents.offer is not None, "the offer")
    return session


def test_offer_tells_when_the_shot_was_left_and_what_is_unsaved(tmp_path):
    path = write_crashed_shot(tmp_path)
    left = datetime.now().replace(hour=3, minute=49).timestamp()
    os.utime(autosave_path(path), (left, left))
    session = open_with_offer(tmp_path, path)
    words = session.files.documents.offer.words
    assert words == "You left this shot unsaved at 03:49: 1 mark, 0 keys."
    session.close()


def test_shot_that_cannot_be_written_is_told_in_a_box_and_is_no_recent_file(
    session, documents, tmp_path
):
    set_marks(session, MARK)
    path = tmp_path / "file" / "pull.heatlens.json"
    path.parent.write_text("a file, and no folder")
    save_shot(session, path)
    assert documents.failed_save and str(path) in documents.failed_save
    assert str(path) not in session.preferences.values.recent and not documents.is_saved
    documents.failed_save = ""
    save_shot(session, tmp_path / "pull.heatlens.json")
    assert not documents.failed_save and documents.is_saved


def test_autosaved_changes_are_offered_and_can_be_restored(tmp_path):
    path = write_crashed_shot(tmp_path)
    session = open_with_offer(tmp_path, path)
    documents = session.files.documents
    assert not documents.needs_autosave and session.source.plate is None
    documents.answer(recovers=True)
    assert documents.offer is None
    run_until_settled(session)
    assert session.editing.shot.marks == (MARK,) and documents.path == path
    assert not documents.is_saved and documents.title.endswith("*")
    documents.answer(recovers=False)  # nothing is offered any more
    assert session.editing.shot.marks == (MARK,)
    session.close()


def test_refused_autosave_is_deleted(tmp_path):
    path = write_crashed_shot(tmp_path)
    session = open_with_offer(tmp_path, path)
    session.files.documents.answer(recovers=False)
    run_until_settled(session)
    assert session.editing.shot.marks == () and session.files.documents.is_saved
    assert not autosave_path(path).exists()
    session.close()


def test_autosave_equal_to_its_file_is_not_offered(tmp_path):
    path = write_crashed_shot(tmp_path, marks=())
    session = begin_session(tmp_path / "preferences", str(path))
    run_until_settled(session)
    assert session.files.documents.offer is None and session.files.documents.path == path
    session.close()


def test_autosave_is_offered_when_its_shot_file_is_gone(tmp_path):
    path = write_crashed_shot(tmp_path)
    path.unlink()
    session = open_with_offer(tmp_path, path)
    session.files.documents.answer(recovers=True)
    run_until_settled(session)
    assert session.editing.shot.marks == (MARK,)
    session.close()


def test_autosave_of_unnamed_shot_is_restored_or_dropped(tmp_path):
    pattern, preferences = write_plates(tmp_path), tmp_path / "preferences"
    session = begin_session(preferences, pattern)
    run_until_settled(session)
    set_marks(session, MARK)
    run_until_settled(session)
    session.close()
    for goes_on in (True, False):
        session = open_with_offer(tmp_path, pattern)
        session.files.documents.answer(goes_on)
        assert session.editing.shot.marks == ((MARK,) if goes_on else ())
        run_until_settled(session)
        session.close()
    session = begin_session(preferences, pattern)
    run_until_settled(session)
    assert session.files.documents.offer is None
    session.close()


def test_unreadable_shot_file_is_reported_and_changes_nothing(session, tmp_path):
    path = tmp_path / "bad.heatlens.json"
    path.write_text("no shot")
    before = session.editing.shot
    session.files.commands.open(str(path))
    run_until(session, lambda: "bad.heatlens.json" in session.messages.text, "the refusal")
    assert session.editing.shot == before
    nameless = tmp_path / "nameless.heatlens.json"
    write_shot(nameless, Shot(LENS))
    session.files.commands.open(str(nameless))
    run_until(session, lambda: "nameless" in session.messages.text, "the refusal")
    assert session.editing.shot == before


def test_failed_save_is_reported_and_shot_stays_unsaved(session, documents, tmp_path):
    documents.save_as(tmp_path / "gone" / "a.heatlens.json")
    run_until(session, lambda: "gone" in session.messages.text, "the refusal")
    assert not documents.is_saved and documents.title.endswith("*")


def test_opened_shot_begins_at_its_in_point(session, tmp_path):
    session.time.timeline.go_to(FIRST + 5)
    session.time.timeline.set_in()
    path = tmp_path / "a.heatlens.json"
    save_shot(session, path)
    other = begin_session(tmp_path / "others", str(path))
    run_until_settled(other)
    assert other.editing.frame == FIRST + 5 == other.editing.shot.in_out.first
    other.close()


def test_opening_another_source_begins_an_unnamed_shot(session, documents, tmp_path):
    save_shot(session, tmp_path / "a.heatlens.json")
    session.files.commands.open(str(room_file(tmp_path / "still.exr", 8, 6)))
    run_until(session, lambda: session.editing.shot.source.endswith("still.exr"), "the still")
    assert (documents.path, documents.title, documents.window_title) == (None, "", "still.exr")


def test_opening_a_saved_shot_restores_its_source_and_frames(session, documents, tmp_path):
    save_shot(session, tmp_path / "a.heatlens.json")
    session.files.commands.open(str(room_file(tmp_path / "still.exr", 8, 6)))
    run_until(session, lambda: session.editing.shot.source.endswith("still.exr"), "the still")
    session.files.commands.open(str(tmp_path / "a.heatlens.json"))
    run_until(session, lambda: documents.path is not None, "the shot")
    run_until_settled(session)
    assert documents.is_saved and session.time.timeline.frames.count == LAST - FIRST + 1


def test_command_line_lens_overrides_lens_of_the_shot_file(tmp_path):
    path = write_crashed_shot(tmp_path, has_autosave=False)
    session = Session(
        FakeRenderer(),
        Start(str(path), lens={"f_stop": 11.0}),
        preferences=Preferences.load(tmp_path / "preferences"),
    )
    session.begin()
    run_until_settled(session)
    assert session.facts.lens.f_stop == 11.0
    assert session.facts.lens.focal_length_mm == LENS.focal_length_mm
    assert session.files.documents.title.endswith("*")
    session.close()


def test_opening_another_file_cancels_the_shot_being_opened(session, documents, tmp_path):
    path = tmp_path / "a.heatlens.json"
    save_shot(session, path)
    set_marks(session, MARK)
    run_until_settled(session)
    documents.open(path)
    still = room_file(tmp_path / "still.exr", 8, 6)
    session.files.commands.open(str(still))
    run_until(session, lambda: session.editing.shot.source == str(still), "the still")
    for _ in range(20):
        run_loop_once(session)
    assert documents.offer is None and documents.path is None


def test_unnamed_path_is_sixteen_hash_digits_of_the_source(tmp_path):
    """The names must not change: autosaves of earlier versions are found by them."""
    path = unnamed_path(tmp_path, "walls.####.exr")
    assert path.parent == tmp_path / "unsaved" and path.name == (
        f"{hashlib.sha256(b'walls.####.exr').hexdigest()[:16]}.heatlens.json"
    )
    assert unnamed_path(tmp_path, "other.exr") != path
