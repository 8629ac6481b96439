"""A reel in a session: one shot is open, the next is a step away, and nothing done is lost."""

import pytest

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.grade import Grade
from heatlens.core.model.shot.reel import Reel, ReelShot
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.reel_file import write_reel
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.render.source import opener
from heatlens.studio.board.board import Board
from heatlens.studio.board.requests import Focus
from heatlens.studio.session.time.playback import Ending
from support.evening import FIRST, LAST, begun, settled, turn, until, write_plates

GRADE = Grade((1.5, 1.0, 0.7), (0.02, 0.0, -0.02), (1.0, 1.1, 0.9), 0.5)
CUT = FrameRange(1005, 1010)


@pytest.fixture
def reel(tmp_path):
    """Write a reel: plates, missing media, and a shot file with a focus of its own."""
    source = write_plates(tmp_path)
    own = tmp_path / "s3.heatlens.json"
    write_shot(own, Shot(Lens(50.0, 2.8, 3.0, 36.0), source=source, frames=FrameRange(FIRST, LAST)))
    gone = ReelShot("s2", "", None, ("its media are missing: /nowhere",))
    path = tmp_path / "cut.heatreel.json"
    write_reel(
        path, Reel("cut", (ReelShot("s1", source, CUT), gone, ReelShot("s3", str(own), CUT)))
    )
    return path


@pytest.fixture
def session(tmp_path, reel):
    session = begun(tmp_path / "preferences", str(reel))
    settled(session)
    yield session
    session.close()


def shown(session, name: str) -> None:
    """Wait until the shot file of this name is open."""

    def is_open() -> bool:
        path = session.files.documents.path
        return path is not None and path.name == name

    until(session, is_open, name)
    settled(session)


def test_a_reel_opens_its_first_shot_with_the_part_of_the_cut(session):
    opened = session.files.reel
    assert opened.at == 0 and session.editing.shot.in_out == CUT
    assert session.editing.frame == CUT.first


def test_steps_pass_missing_media_and_end_with_a_sentence(session):
    opened, door = session.files.reel, Board(session)
    door.do("Next shot")
    shown(session, "s3.heatlens.json")
    assert opened.at == 2
    door.do("Next shot")
    assert opened.at == 2 and "last shot" in session.messages.text
    door.do("Previous shot")
    settled(session)
    assert opened.at == 0 and session.editing.shot.in_out == CUT
    opened.go(1)
    assert opened.at == 0 and "/nowhere" in session.messages.text


def test_going_on_saves_a_shot_that_has_a_file(session, reel):
    opened, door = session.files.reel, Board(session)
    opened.go(2)
    shown(session, "s3.heatlens.json")
    door.do(Focus(5.0))
    settled(session)
    opened.go(0)
    settled(session)
    assert read_shot(reel.parent / "s3.heatlens.json").lens.focus_distance_m == 5.0
    assert opened.focus_of(2).first_m == 5.0


def test_the_focus_of_both_sides_of_a_cut_is_known_before_a_shot_is_opened(session):
    opened = session.files.reel
    assert opened.focus_of(2).first_m == opened.focus_of(2).last_m == 3.0
    assert opened.focus_of(0).last_m == session.editing.shot.lens_at(CUT.last).focus_distance_m


def test_without_a_reel_there_is_no_other_shot(walls):
    commands = {command.name: command for command in Board(walls).commands}
    assert commands["Next shot"].why_not() and not commands["Next shot"].is_on


def test_another_file_can_be_opened_beside_the_reel(session, tmp_path):
    """Then the list stays, and its next shot is opened as before."""
    (tmp_path / "other").mkdir()
    other = write_plates(tmp_path / "other")
    session.files.commands.open(other)
    until(session, lambda: session.editing.shot.source == other, "the other plates")
    session.files.reel.go(2)
    shown(session, "s3.heatlens.json")
    assert session.files.reel.at == 2


@pytest.fixture
def cut(tmp_path):
    """Open a reel of two plates, a shot that is missing and a shot file; all of two frames."""
    sources = []
    for name in ("a", "b", "c"):
        (tmp_path / name).mkdir()
        sources.append(write_plates(tmp_path / name))
    own = tmp_path / "c.heatlens.json"
    frames = FrameRange(1003, 1004)
    lens = Lens(50.0, 2.8, 3.0, 36.0)
    write_shot(own, Shot(lens, source=sources[2], frames=FrameRange(FIRST, LAST), in_out=frames))
    shots = (
        ReelShot("a", sources[0], FrameRange(1005, 1006)),
        ReelShot("gone", "", None, ("its media are missing: /nowhere",)),
        ReelShot("b", sources[1], FrameRange(1010, 1011)),
        ReelShot("c", str(own)),
    )
    path = tmp_path / "cut.heatreel.json"
    write_reel(path, Reel("cut", shots))
    session = begun(tmp_path / "preferences", str(path))
    settled(session)
    yield session
    session.close()


def played(session, count: int) -> list[tuple[str, int]]:
    """Play on until the playhead was on `count` frames; return them with their plates."""
    seen: list[tuple[str, int]] = []

    def has_all() -> bool:
        now = session.editing.shot.source.split("/")[-2], session.editing.frame
        if not seen or seen[-1] != now:
            seen.append(now)
        return len(seen) == count

    until(session, has_all, "the end")
    return seen


THROUGH = [("a", 1005), ("a", 1006), ("b", 1010), ("b", 1011), ("c", 1003), ("c", 1004)]


def test_playback_goes_on_across_cuts_and_begins_again(cut):
    timeline = cut.time.timeline
    timeline.playback.ending = Ending.REEL
    timeline.play(1)
    assert played(cut, 8) == [*THROUGH, *THROUGH[:2]]
    assert timeline.playback.direction == 1 and cut.files.reel.at == 0


def test_other_endings_stay_in_the_shot(cut):
    cut.time.timeline.play(1)
    assert played(cut, 4) == [*THROUGH[:2], *THROUGH[:2]]


def test_playback_stops_where_the_next_shot_cannot_be_opened(cut, tmp_path):
    cut.files.reel.go(2)
    settled(cut)
    (tmp_path / "c.heatlens.json").write_text("{")
    timeline = cut.time.timeline
    timeline.playback.ending = Ending.REEL
    timeline.play(1)
    until(cut, lambda: timeline.playback.direction == 0, "the stop")
    assert "c.heatlens.json" in cut.messages.text
    assert cut.editing.shot.source == str(tmp_path / "b" / "walls.####.exr")


def test_the_next_shot_is_opened_before_it_is_asked_for(cut, tmp_path, monkeypatch):
    """Its first plate is read while the shot before is open, and not once more at the cut."""
    prepared = cut.source.opener._ahead
    until(cut, lambda: prepared._coming is not None and prepared._coming.done(), "the next plate")
    monkeypatch.setattr(opener, "_opened", lambda _: pytest.fail("opened once more"))
    cut.files.reel.step(1)
    turn(cut)
    assert cut.editing.shot.source == str(tmp_path / "b" / "walls.####.exr")
    assert cut.editing.frame == 1010


def test_the_part_of_the_cut_is_no_change_of_the_user(cut, tmp_path):
    """Nothing of it is offered after a crash, and nothing asks in the middle of playback."""
    assert cut.editing.shot.in_out == FrameRange(1005, 1006)
    assert not cut.files.documents.window_title.endswith("*")
    assert not cut.editing.history.past
    settled(cut)
    assert not list(tmp_path.rglob("unsaved/*"))


def test_the_part_of_the_cut_counts_for_a_shot_with_a_file_too(session):
    """It plays what the reel shows of it, from its first frame, and that is no change."""
    session.files.reel.go(2)
    shown(session, "s3.heatlens.json")
    assert session.editing.shot.in_out == CUT and session.editing.frame == CUT.first
    assert session.time.timeline.played == CUT
    assert session.files.documents.is_saved and not session.editing.history.past


def test_a_shot_opened_by_itself_keeps_its_own_part(session, reel):
    session.files.reel.go(2)
    shown(session, "s3.heatlens.json")
    session.files.commands.open(str(reel.parent / "s3.heatlens.json"))
    until(session, lambda: session.editing.shot.in_out is None, "the whole shot")


def test_a_shot_without_a_file_comes_back_as_it_was_left(cut, tmp_path):
    """With its focus and its keys, and without a question as after a crash."""
    opened, door = cut.files.reel, Board(cut)
    door.do(Focus(3.0))
    cut.files.reel.step(1)
    until(cut, lambda: cut.editing.shot.source == str(tmp_path / "b" / "walls.####.exr"), "b")
    settled(cut)
    door.do("Set key")
    opened.step(-1)
    until(cut, lambda: cut.editing.shot.source == str(tmp_path / "a" / "walls.####.exr"), "a")
    settled(cut)
    assert cut.editing.shot.lens.focus_distance_m == 3.0
    assert cut.editing.shot.in_out == FrameRange(1005, 1006)
    opened.step(1)
    until(cut, lambda: cut.editing.shot.source == str(tmp_path / "b" / "walls.####.exr"), "b again")
    settled(cut)
    assert cut.editing.shot.key_frames == (1010.0,)
    assert cut.files.documents.offer is None and not cut.files.documents.is_reading


def test_a_clip_is_shown_with_the_grade_of_the_edit(tmp_path):
    """And with the switch off without it; the export then leaves it out too."""
    source, path = write_plates(tmp_path), tmp_path / "cut.heatreel.json"
    write_reel(
        path, Reel("cut", (ReelShot("s1", source, CUT, grade=GRADE), ReelShot("s2", source)))
    )
    session = begun(tmp_path / "preferences", str(path))
    settled(session)
    try:
        assert session.editing.shot.grade == GRADE and not session.editing.history.past
        color, screen = session.pictures.color, Screen()
        color.apply(session.facts.view, screen, session.facts.shot.grade)
        graded = color.transform.key
        assert session.pictures.look.options().cdl is None
        Board(session).do("Grade of the shot")
        color.apply(session.facts.view, screen, session.facts.shot.grade)
        assert color.transform.key != graded
        assert session.pictures.look.options().cdl == "none"
        session.files.reel.go(1)
        settled(session)
        assert session.editing.shot.grade is None
        assert {c.name: c for c in Board(session).commands}["Grade of the shot"].why_not()
    finally:
        session.close()


class Screen:
    """Stands for the pictures on the screen."""

    transform_version = 0

    @property
    def display(self):
        return self

    def set_transform(self, transform) -> None:
        """Take any transform."""


def test_a_grade_is_imported_as_one_step(session, tmp_path):
    path = tmp_path / "a.cc"
    path.write_text(
        "<ColorCorrection><SOPNode><Slope>1.5 1 0.7</Slope><Offset>0.02 0 -0.02</Offset>"
        "<Power>1 1.1 0.9</Power></SOPNode><SatNode><Saturation>0.5</Saturation></SatNode>"
        "</ColorCorrection>"
    )
    session.files.commands.grades.begin(path)
    until(session, lambda: session.editing.shot.grade is not None, "the grade")
    assert session.editing.shot.grade == GRADE and "a.cc" in session.messages.text
    session.editing.undo()
    assert session.editing.shot.grade is None
