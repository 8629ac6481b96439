"""Shot files of a session: opened, saved, kept beside, offered after a crash, and named."""

import hashlib
from dataclasses import replace

import pytest

from heatlens.core.model.marks.marks import DistanceMark
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.shot_file import autosave_path, read_shot, write_autosave, write_shot
from heatlens.studio.session.session import Session
from heatlens.studio.session.settings.preferences import Preferences
from heatlens.studio.session.shot.shot_store import proposed_name, unnamed_path
from heatlens.studio.session.shot.start import Start
from support.evening import FIRST, LAST, begun, settled, turn, until, write_plates
from support.fake_renderer import FakeRenderer
from support.session_files import LENS, room_file

MARK = DistanceMark("A", 3.0)


@pytest.fixture
def documents(walls):
    return walls.files.documents


def marked(session, *marks):
    session.editing.do(replace(session.editing.shot, marks=marks))


def saved(session, path):
    session.files.documents.save_as(path)
    settled(session)


def test_a_star_stands_for_what_is_not_in_the_file(walls, documents, tmp_path):
    assert (documents.title, documents.shot_name, documents.window_title) == (
        *("", "", "walls.####.exr"),
    )
    assert not documents.is_saved and not documents.save()
    marked(walls, MARK)
    assert documents.window_title == "walls.####.exr *"
    path = tmp_path / "walls.v1.heatlens.json"
    saved(walls, path)
    assert documents.title == path.name == documents.window_title and documents.is_saved
    assert documents.shot_name == "walls" and documents.proposed_name() == path.name
    assert f"Saved {path}" in walls.messages.text
    marked(walls)
    assert documents.title == f"{path.name} *" == documents.window_title
    walls.editing.undo()
    assert documents.title == path.name
    marked(walls)
    assert documents.save()
    settled(walls)
    assert read_shot(path) == walls.editing.shot and documents.is_saved
    assert walls.preferences.now.recent[0] == str(path)


def test_the_frames_of_a_sequence_are_saved_and_those_of_a_still_are_not(walls, tmp_path):
    path = tmp_path / "a.heatlens.json"
    saved(walls, path)
    assert tuple(read_shot(path).frames) == tuple(range(FIRST, LAST + 1))
    still = begun(tmp_path / "others", str(room_file(tmp_path / "still.exr", 8, 6)))
    settled(still)
    saved(still, tmp_path / "b.heatlens.json")
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
def test_a_shot_is_named_after_its_plate(tmp_path, plate, is_numbered, name):
    assert proposed_name(tmp_path / plate, is_numbered) == f"{name}.heatlens.json"


def test_changes_are_kept_beside_the_file_and_dropped_when_it_is_saved(walls, documents, tmp_path):
    path = tmp_path / "a.heatlens.json"
    saved(walls, path)
    assert not autosave_path(path).exists()
    marked(walls, MARK)
    settled(walls)
    assert read_shot(autosave_path(path)).marks == (MARK,) and read_shot(path).marks == ()
    walls.editing.undo()
    settled(walls)
    assert not autosave_path(path).exists()
    walls.editing.redo()
    settled(walls)
    documents.save()
    settled(walls)
    assert not autosave_path(path).exists() and not documents.is_behind


def test_a_gesture_is_kept_when_it_ends_or_at_once_after_a_fault(walls, documents, tmp_path):
    path = tmp_path / "a.heatlens.json"
    saved(walls, path)
    walls.editing.edit(replace(walls.editing.shot, marks=(MARK,)))
    assert documents.is_behind
    documents.poll()
    assert not autosave_path(path).exists()  # the hand still moves
    documents.keep_now()
    assert read_shot(autosave_path(path)).marks == (MARK,)
    written = autosave_path(path).stat().st_mtime_ns
    documents.keep_now()
    assert autosave_path(path).stat().st_mtime_ns == written  # nothing is new


def test_a_shot_without_marks_or_keys_leaves_nothing_behind(tmp_path):
    pattern, preferences = write_plates(tmp_path), tmp_path / "preferences"
    kept = autosave_path(unnamed_path(preferences, pattern))
    for marks in ((), (MARK,)):
        session = begun(preferences, pattern)
        settled(session)
        session.lens.commands.focus(3.0)
        session.editing.settle()
        marked(session, *marks)
        settled(session)
        assert kept.exists()
        session.close()
        assert kept.exists() is bool(marks)


def crashed(tmp_path, marks=(MARK,), keeps=True):
    """Return a shot file whose unsaved changes are kept beside it."""
    pattern, path = write_plates(tmp_path), tmp_path / "a.heatlens.json"
    write_shot(path, Shot(LENS, source=pattern))
    if keeps:
        write_autosave(path, replace(read_shot(path), marks=marks))
    return path


def offered(tmp_path, path):
    session = begun(tmp_path / "preferences", str(path))
    until(session, lambda: session.files.documents.offer is not None, "the offer")
    return session


def test_unsaved_changes_are_offered_and_taken(tmp_path):
    path = crashed(tmp_path)
    session = offered(tmp_path, path)
    documents = session.files.documents
    assert not documents.is_behind and session.source.plate is None
    documents.answer(goes_on=True)
    assert documents.offer is None
    settled(session)
    assert session.editing.shot.marks == (MARK,) and documents.path == path
    assert not documents.is_saved and documents.title.endswith("*")
    documents.answer(goes_on=False)  # nothing is offered any more
    assert session.editing.shot.marks == (MARK,)
    session.close()


def test_unsaved_changes_are_dropped_where_nobody_wants_them(tmp_path):
    path = crashed(tmp_path)
    session = offered(tmp_path, path)
    session.files.documents.answer(goes_on=False)
    settled(session)
    assert session.editing.shot.marks == () and session.files.documents.is_saved
    assert not autosave_path(path).exists()
    session.close()


def test_what_is_the_same_as_the_file_is_not_offered(tmp_path):
    path = crashed(tmp_path, marks=())
    session = begun(tmp_path / "preferences", str(path))
    settled(session)
    assert session.files.documents.offer is None and session.files.documents.path == path
    session.close()


def test_unsaved_changes_without_their_file_are_offered(tmp_path):
    path = crashed(tmp_path)
    path.unlink()
    session = offered(tmp_path, path)
    session.files.documents.answer(goes_on=True)
    settled(session)
    assert session.editing.shot.marks == (MARK,)
    session.close()


def test_an_unnamed_shot_is_taken_up_again_or_let_go(tmp_path):
    pattern, preferences = write_plates(tmp_path), tmp_path / "preferences"
    session = begun(preferences, pattern)
    settled(session)
    marked(session, MARK)
    settled(session)
    session.close()
    for goes_on in (True, False):
        session = offered(tmp_path, pattern)
        session.files.documents.answer(goes_on)
        assert session.editing.shot.marks == ((MARK,) if goes_on else ())
        settled(session)
        session.close()
    session = begun(preferences, pattern)
    settled(session)
    assert session.files.documents.offer is None
    session.close()


def test_files_that_are_no_shots_are_told(walls, tmp_path):
    path = tmp_path / "bad.heatlens.json"
    path.write_text("no shot")
    before = walls.editing.shot
    walls.files.commands.open(str(path))
    until(walls, lambda: "bad.heatlens.json" in walls.messages.text, "the refusal")
    assert walls.editing.shot == before
    nameless = tmp_path / "nameless.heatlens.json"
    write_shot(nameless, Shot(LENS))
    walls.files.commands.open(str(nameless))
    until(walls, lambda: "nameless" in walls.messages.text, "the refusal")
    assert walls.editing.shot == before


def test_a_shot_that_cannot_be_written_is_told_and_stays_unsaved(walls, documents, tmp_path):
    folder = tmp_path / "gone"
    documents.save_as(folder / "a.heatlens.json")
    until(walls, lambda: "gone" in walls.messages.text, "the refusal")
    assert not documents.is_saved and documents.title.endswith("*")


def test_a_shot_begins_at_its_in_point_with_its_own_options(walls, tmp_path):
    walls.time.timeline.go(FIRST + 5)
    walls.time.timeline.set_in()
    path = tmp_path / "a.heatlens.json"
    saved(walls, path)
    session = begun(tmp_path / "others", str(path))
    settled(session)
    assert session.editing.frame == FIRST + 5 and session.editing.shot.in_out.first == FIRST + 5
    session.close()


def test_another_source_begins_another_shot(walls, documents, tmp_path):
    saved(walls, tmp_path / "a.heatlens.json")
    walls.files.commands.open(str(room_file(tmp_path / "still.exr", 8, 6)))
    until(walls, lambda: walls.editing.shot.source.endswith("still.exr"), "the still")
    assert documents.path is None and documents.title == ""
    assert documents.window_title == "still.exr"
    walls.files.commands.open(str(tmp_path / "a.heatlens.json"))
    until(walls, lambda: documents.path is not None, "the shot")
    settled(walls)
    assert documents.is_saved and walls.time.timeline.frames.count == LAST - FIRST + 1


def test_a_lens_of_the_command_line_goes_over_that_of_the_shot_file(tmp_path):
    path = crashed(tmp_path, keeps=False)
    session = Session(
        FakeRenderer(),
        Start(str(path), lens={"f_stop": 11.0}),
        preferences=Preferences.load(tmp_path / "preferences"),
    )
    session.begin()
    settled(session)
    assert session.facts.lens.f_stop == 11.0
    assert session.facts.lens.focal_length_mm == LENS.focal_length_mm
    assert session.files.documents.title.endswith("*")
    session.close()


def test_a_shot_that_is_not_waited_for_any_more_is_forgotten(walls, documents, tmp_path):
    path = tmp_path / "a.heatlens.json"
    saved(walls, path)
    marked(walls, MARK)
    settled(walls)
    documents.open(path)
    still = room_file(tmp_path / "still.exr", 8, 6)
    walls.files.commands.open(str(still))
    until(walls, lambda: walls.editing.shot.source == str(still), "the still")
    for _ in range(20):
        turn(walls)
    assert documents.offer is None and documents.path is None


def test_an_unnamed_shot_is_kept_under_sixteen_digits_of_its_source(tmp_path):
    """The names stay what they are, or shots of earlier versions would not be found."""
    path = unnamed_path(tmp_path, "walls.####.exr")
    assert path.parent == tmp_path / "unsaved" and path.name == (
        f"{hashlib.sha256(b'walls.####.exr').hexdigest()[:16]}.heatlens.json"
    )
    assert unnamed_path(tmp_path, "other.exr") != path
