"""A front end of 40 lines, which knows the board and the model alone: open, drag, mark, export."""

import ast
import inspect
import textwrap
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from heatlens.studio.board.board import Board
from heatlens.studio.board.facts import Facts
from heatlens.studio.board.requests import Export, MarkAt, Open
from support.evening import FAR_M, FIRST, begin_session, run_loop_once, write_plates
from support.patience import PATIENCE_S

LINES_MOST = 40
MAY_IMPORT = ("heatlens.studio.board.", "heatlens.core.")


class FrontEnd:
    """Shows a session as text; `turn` makes one turn of its loop."""

    def __init__(self, board: Board, turn: Callable[[], None]) -> None:
        self.board, self._turn = board, turn

    def until(self, condition: Callable[[Facts], bool]) -> Facts:
        """Turn until the facts fulfil a condition; return them."""
        while not condition(facts := self.board.facts):
            self._turn()
        return facts

    def open(self, name: str) -> Facts:
        """Open a source; return the facts with its whole picture."""
        self.board.do(Open(name))
        return self.until(lambda facts: bool(facts.shot.source) and facts.is_whole)

    def drag_focus(self, to_m: float, steps: int = 4) -> Facts:
        """Move the focus to a distance as a hand does; return the facts at rest."""
        lens = self.board.facts.lens
        for part in (step / steps for step in range(1, steps + 1)):
            distance_m = (1 - part) * lens.focus_distance_m + part * to_m
            self.board.change(replace(lens, focus_distance_m=distance_m))
            self._turn()
        return self.until(lambda facts: facts.is_whole)

    def mark(self, x_px: int, y_px: int) -> Facts:
        """Set a mark on what is at a pixel."""
        self.board.do(MarkAt(x_px, y_px))
        return self.until(lambda facts: bool(facts.marks))

    def export(self, folder: Path, frame: int) -> Facts:
        """Export a frame; return the facts once that has ended."""
        self.board.do(Export(str(folder), "shot", str(frame)))
        return self.until(lambda facts: facts.message.startswith("Done") or facts.is_problem)


@pytest.fixture
def front_end(tmp_path):
    session = begin_session(tmp_path / "preferences")
    end_s = time.monotonic() + PATIENCE_S

    def turn() -> None:
        assert time.monotonic() < end_s, session.messages.text
        run_loop_once(session)
        time.sleep(0.001)  # threads have their turn

    yield FrontEnd(Board(session), turn)
    session.close()


def test_small_front_end_opens_drags_marks_and_exports(front_end, tmp_path):
    opened = front_end.open(write_plates(tmp_path))
    assert (opened.frame, opened.size_px) == (FIRST, (48, 32))
    dragged = front_end.drag_focus(6.0)
    assert dragged.lens.focus_distance_m == 6.0
    assert dragged.picture > opened.picture  # numbers of pictures: a new one was drawn
    (mark,) = front_end.mark(x_px=40, y_px=16).marks
    assert mark.distance_m == FAR_M
    exported = front_end.export(tmp_path / "out", FIRST + 2)
    assert not exported.is_problem, exported.message
    assert [it.name for it in (tmp_path / "out").iterdir()] == [f"shot.{FIRST + 2}.exr"]


def test_drag_is_one_step_of_undo(front_end, tmp_path):
    before = front_end.open(write_plates(tmp_path)).lens
    front_end.drag_focus(6.0)
    front_end.until(lambda facts: facts.title.endswith("*"))
    front_end.board.do("Undo")
    assert front_end.board.facts.lens == before


def test_small_front_end_has_40_lines_and_knows_the_board_alone():
    lines = textwrap.dedent(inspect.getsource(FrontEnd)).splitlines()
    assert len([line for line in lines if line.strip()]) <= LINES_MOST
    tree = ast.parse(Path(__file__).read_text(encoding="utf-8"))
    modules = [node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    own = [name for name in modules if name.startswith("heatlens.")]
    assert own and all(name.startswith(MAY_IMPORT) for name in own)


def test_export_tells_what_is_missing(front_end, tmp_path):
    front_end.board.do(Export(str(tmp_path / "out"), "shot"))
    assert front_end.board.facts.message == "Nothing is open to export."
    assert not (tmp_path / "out").exists()
    front_end.open(write_plates(tmp_path))
    front_end.board.do(Export(str(tmp_path / "out"), "shot", str(FIRST)))
    front_end.board.do(Export(str(tmp_path / "out"), "shot", str(FIRST)))
    assert "begin another when it has finished" in front_end.board.facts.message
