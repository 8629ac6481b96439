"""A reel made in a session: dropped, put in order, saved with the pulls of its shots."""

import pytest

from heatlens.core.model.curves.frames import FrameRange
from heatlens.media.documents.reel_file import read_reel, write_reel
from heatlens.media.documents.shot_file import read_shot
from heatlens.studio.board.board import Board
from heatlens.studio.board.requests import Focus
from support.evening import begin_session, run_until, run_until_settled, write_plates


@pytest.fixture
def sources(tmp_path):
    """Write three sequences, each in a folder of its own."""
    patterns = []
    for name in ("a", "b", "c"):
        (tmp_path / name).mkdir()
        patterns.append(write_plates(tmp_path / name))
    return patterns


@pytest.fixture
def session(tmp_path):
    session = begin_session(tmp_path / "settings")
    yield session
    session.close()


def drop(session, names) -> None:
    """Drop files on the window, and wait until the shot that they open has its picture."""
    session.files.commands.open_dropped([str(name) for name in names])
    run_until(session, lambda: session.source.plate is not None, "a picture")
    run_until_settled(session)


def sources_of(session) -> list[str]:
    return [shot.source for shot in session.files.reel.reel.shots]


def test_dropped_frames_of_three_sequences_are_a_reel_of_three_shots(session, sources):
    names = [pattern.replace("####", str(n)) for pattern in sources for n in (1001, 1002, 1003)]
    drop(session, names)
    reel = session.files.reel
    assert sources_of(session) == sources and reel.number == 0 and reel.is_open
    assert [shot.name for shot in reel.reel.shots] == ["walls", "walls_2", "walls_3"]
    assert session.files.window_title == "New reel *, 1 of 3: walls"


def test_dropped_frames_of_one_sequence_open_it_without_a_reel(session, sources):
    drop(session, [sources[1].replace("####", str(frame)) for frame in (1001, 1002)])
    assert session.editing.shot.source == sources[1] and session.files.reel.reel is None


def test_file_dropped_on_a_reel_is_added_and_a_named_file_is_opened(session, sources):
    drop(session, sources[:2])
    session.files.commands.open_dropped([sources[2]])
    run_until(session, lambda: len(sources_of(session)) == 3, "the third shot")
    assert session.editing.shot.source == sources[0]
    session.files.commands.open_named([sources[2]])
    run_until(session, lambda: session.editing.shot.source == sources[2], "the file")
    assert sources_of(session) == sources and not session.files.reel.is_open


def test_file_that_is_no_shot_leaves_the_reel_as_it_is(session, sources, tmp_path):
    drop(session, sources[:2])
    (tmp_path / "notes.txt").write_text("none")
    session.files.commands.open_dropped([str(tmp_path / "notes.txt")])
    run_until(session, lambda: session.messages.is_problem, "the reason")
    assert sources_of(session) == sources[:2] and "notes.txt" in session.messages.text


def test_removed_open_shot_keeps_its_edits_and_the_next_opens(session, sources):
    drop(session, sources)
    editing, reel = session.files.commands.reel_editing, session.files.reel
    reel.go(1)
    run_until(session, lambda: session.editing.shot.source == sources[1], "the second shot")
    run_until_settled(session)
    editing.remove(1)
    run_until(session, lambda: session.editing.shot.source == sources[2], "the third shot")
    assert sources_of(session) == [sources[0], sources[2]] and reel.number == 1
    editing.remove(0)
    editing.remove(0)
    assert reel.reel is None and session.editing.shot.source == sources[2]


def test_removed_shot_comes_back_to_its_place_by_the_notice(session, sources):
    drop(session, sources)
    editing, notices = session.files.commands.reel_editing, session.files.notices
    editing.remove(1)
    notice = notices.first
    assert notice.words.startswith("Removed ") and sources_of(session) == [sources[0], sources[2]]
    notices.answer(notice, next(it for it in notice.answers if it.words == "Put it back"))
    assert sources_of(session) == sources and notices.first is None
    editing.remove(2)
    notices.answer(notices.first)
    assert notices.first is None and sources_of(session) == sources[:2]
    editing.move(0, 1)
    assert editing.removed is None


def test_moved_shot_stays_open_and_its_neighbours_follow(session, sources):
    drop(session, sources)
    session.files.commands.reel_editing.move(0, 2)
    assert sources_of(session) == [*sources[1:], sources[0]] and session.files.reel.number == 2
    Board(session).do("Previous shot")
    run_until(session, lambda: session.editing.shot.source == sources[2], "the shot before")


def test_new_reel_begins_with_the_open_shot_and_its_part(session, sources):
    assert not session.files.commands.reel_editing.begin()
    drop(session, sources[:1])
    session.time.timeline.go_to(1005)
    Board(session).do("Set in point")
    assert session.files.commands.reel_editing.begin()
    (shot,) = session.files.reel.reel.shots
    assert (shot.source, shot.frames) == (sources[0], FrameRange(1005, 1024))


def test_saved_reel_has_shot_files_of_edited_shots(session, sources, tmp_path):
    """The open shot and one that was left keep their focus in files; the third stays plates."""
    drop(session, sources)
    board, path = Board(session), tmp_path / "evening.heatreel.json"
    for number, focus_m in ((1, 5.0), (0, 3.0)):
        session.files.reel.go(number)
        run_until(
            session, lambda number=number: session.editing.shot.source == sources[number], "shot"
        )
        run_until_settled(session)
        board.do(Focus(focus_m))
    assert not session.files.commands.reel_editing.save()  # it has no name yet
    session.files.commands.reel_editing.save_as(path)
    run_until(session, lambda: session.files.reel.name == path.name, "the file")
    run_until_settled(session)
    shots = read_reel(path).shots
    assert [shot.source for shot in shots[:2]] == [
        str(tmp_path / f"{name}.heatlens.json") for name in ("walls", "walls_2")
    ]
    assert shots[2].source == sources[2]
    focus_distances_m = [read_shot(shot.source).lens.focus_distance_m for shot in shots[:2]]
    assert focus_distances_m == [3.0, 5.0]
    assert session.files.window_title == "evening.heatreel.json, 1 of 3: walls"
    session.files.commands.reel_editing.move(2, 0)
    assert session.files.window_title.startswith("evening.heatreel.json *, 2 of 3")
    assert session.files.commands.reel_editing.save()
    run_until(session, lambda: read_reel(path).shots[0].source == sources[2], "the new order")


def test_shot_files_get_names_of_their_own_where_one_is_taken(session, sources, tmp_path):
    """The first shot takes the name of the second: a file with its own name exists."""
    drop(session, sources)
    reel, path = session.files.reel, tmp_path / "cut.heatreel.json"
    (tmp_path / "walls.heatlens.json").write_text("")
    for number in (1, 0):
        reel.go(number)
        run_until(
            session, lambda number=number: session.editing.shot.source == sources[number], "shot"
        )
        run_until_settled(session)
        Board(session).do(Focus(3.0 + 2 * number))
    session.files.commands.reel_editing.save_as(path)
    run_until(session, path.exists, "the file")
    run_until_settled(session)
    files = [shot.source for shot in read_reel(path).shots[:2]]
    assert [read_shot(it).lens.focus_distance_m for it in files] == [3.0, 5.0]


def test_unsaved_reel_is_kept_with_the_settings_until_it_is_saved(session, sources, tmp_path):
    drop(session, sources)
    kept_path = tmp_path / "settings" / "unsaved" / "unsaved.heatreel.json"
    run_until(session, kept_path.exists, "the kept reel")
    run_until_settled(session)
    assert [shot.source for shot in read_reel(kept_path).shots] == sources
    assert str(kept_path) in session.preferences.values.recent
    session.files.commands.reel_editing.save_as(tmp_path / "cut.heatreel.json")
    run_until(session, lambda: not kept_path.exists(), "the end of the kept reel")
    run_until_settled(session)
    assert str(kept_path) not in session.preferences.values.recent


def test_kept_reel_opened_again_asks_for_a_name_and_is_not_lost(session, sources, tmp_path):
    drop(session, sources)
    kept_path = tmp_path / "settings" / "unsaved" / "unsaved.heatreel.json"
    run_until(session, kept_path.exists, "the kept reel")
    session.files.commands.open(str(kept_path))
    run_until(session, lambda: session.files.reel.path == kept_path, "the kept reel")
    run_until_settled(session)
    assert not session.files.commands.reel_editing.save()
    session.files.commands.reel_editing.save_as(kept_path)
    run_until_settled(session)
    assert len(read_reel(kept_path).shots) == 3


def test_edit_of_another_program_is_saved_as_a_reel(session, sources, tmp_path):
    """Its own file is never written."""
    drop(session, sources)
    otio = tmp_path / "cut.otio"
    session.files.reel.path = otio
    assert not session.files.commands.reel_editing.save() and not otio.exists()


def test_file_that_cannot_be_written_leaves_the_reel_unsaved(session, sources, tmp_path):
    drop(session, sources)
    (tmp_path / "file").write_text("")
    session.files.commands.reel_editing.save_as(tmp_path / "file" / "cut.heatreel.json")
    run_until(session, lambda: session.messages.is_problem, "the reason")
    assert session.files.reel.name.endswith("*") and sources_of(session) == sources


def test_reel_of_a_file_keeps_its_gaps_where_shots_move(session, sources, tmp_path):
    drop(session, sources)
    reel = session.files.reel.reel
    path = tmp_path / "gaps.heatreel.json"
    write_reel(path, type(reel)("gaps", reel.shots, gaps=((1, 12), (3, 5))))
    session.files.commands.open(str(path))
    run_until(session, lambda: session.files.reel.path == path, "the reel")
    run_until_settled(session)
    session.files.commands.reel_editing.move(1, 2)
    assert session.files.reel.reel.gaps == ((2, 12), (3, 5))
