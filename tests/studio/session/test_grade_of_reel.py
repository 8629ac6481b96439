"""The grade of a reel's shot in a session: shown, exported, switched off and imported."""

import pytest

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.grade import Grade
from heatlens.core.model.shot.reel import Reel, ReelShot
from heatlens.media.documents.reel_file import write_reel
from heatlens.studio.board.board import Board
from support.evening import begin_session, run_until, run_until_settled, write_plates

GRADE = Grade((1.5, 1.0, 0.7), (0.02, 0.0, -0.02), (1.0, 1.1, 0.9), 0.5)
CUT = FrameRange(1005, 1010)
GRADE_OF_SHOT, NO_GRADE = None, "none"  # the export option --cdl


class FakeScreen:
    """A fake of the pictures on the screen."""

    transform_version = 0

    @property
    def display(self):
        return self

    def set_transform(self, transform) -> None:
        """Take any transform."""


@pytest.fixture
def graded(tmp_path):
    """Return a session with a reel of a graded shot and an ungraded one; the first is open."""
    source, path = write_plates(tmp_path), tmp_path / "cut.heatreel.json"
    write_reel(
        path, Reel("cut", (ReelShot("s1", source, CUT, grade=GRADE), ReelShot("s2", source)))
    )
    session = begin_session(tmp_path / "preferences", str(path))
    run_until_settled(session)
    yield session
    session.close()


def color_key(session):
    """Return the key of the transform that brings the shot's colors to the screen."""
    color = session.pictures.color
    color.apply(session.facts.view, FakeScreen(), session.facts.shot.grade)
    return color.transform.key


def test_grade_of_reel_shot_is_on_screen_and_in_export_unless_switched_off(graded):
    assert graded.editing.shot.grade == GRADE and not graded.editing.history.past
    graded_key = color_key(graded)
    assert graded.pictures.display.options().cdl is GRADE_OF_SHOT
    Board(graded).do("Grade of the shot")
    assert color_key(graded) != graded_key
    assert graded.pictures.display.options().cdl == NO_GRADE


def test_grade_command_is_disabled_for_shot_without_grade(graded):
    graded.files.reel.go(1)
    run_until_settled(graded)
    assert graded.editing.shot.grade is None
    assert {it.name: it for it in Board(graded).commands}["Grade of the shot"].why_not()


def test_import_of_a_grade_is_one_undo_step(session, tmp_path):
    path = tmp_path / "a.cc"
    path.write_text(
        "<ColorCorrection><SOPNode><Slope>1.5 1 0.7</Slope><Offset>0.02 0 -0.02</Offset>"
        "<Power>1 1.1 0.9</Power></SOPNode><SatNode><Saturation>0.5</Saturation></SatNode>"
        "</ColorCorrection>"
    )
    session.files.commands.grades.begin(path)
    run_until(session, lambda: session.editing.shot.grade is not None, "the grade")
    assert session.editing.shot.grade == GRADE and "a.cc" in session.messages.text
    session.editing.undo()
    assert session.editing.shot.grade is None
