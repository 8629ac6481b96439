"""A kind of mark is one class: a new kind defined here works everywhere that handles marks.

It stands on a row of the picture, and its distance is that of the nearest surface of the row.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Self

import pytest

from heatlens.core.model.marks import marks
from heatlens.core.model.marks.mark import Mark
from heatlens.deliver.export.sheet_page import mark_distances
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import read_shot
from support.command_line import stderr_of_run
from support.evening import FIRST, LAST, NEAR_M, run_until, write_plates


class NearestInRow:
    """Measures the mark on a plate."""

    def __call__(self, plate, mark):
        return float(plate.depth_m[mark.row].min())


@dataclass(frozen=True, slots=True)
class RowMark(Mark):
    """A row of the picture."""

    row: int

    help = "on a row of the picture as NAME=row:ROW"
    prefix_pattern = "=row:"
    entry = "row"
    on_plate = NearestInRow()

    @classmethod
    def parse(cls, name: str, place: str) -> Self:
        return cls(name, int(place))

    def location_words(self, distance: Callable[[float], str]) -> str:
        return f"row {self.row}"

    @property
    def meaning(self) -> str:
        return f"The nearest surface of row {self.row}"


@pytest.fixture(autouse=True)
def kinds(monkeypatch):
    monkeypatch.setattr(marks, "KINDS", (RowMark, *marks.KINDS))


def test_new_kind_of_mark_works_in_command_line_and_shot_file(tmp_path, capsys):
    out, lens = tmp_path / "s.heatlens.json", ("--f-stop", "2", "--follow", "A=row:3")
    stderr_of_run(capsys, 0, "shot", "new", write_plates(tmp_path), "-o", out, *lens)
    shot = read_shot(out)
    assert shot.marks == (RowMark("A", 3),)
    assert shot.lens_at(FIRST).focus_distance_m == pytest.approx(NEAR_M, rel=1e-3)
    main(["shot", "show", str(out)])
    assert "row 3" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(["shot", "new", "--help-all"])
    assert "NAME=row:ROW" in "".join(capsys.readouterr().out.split("\n"))


def test_new_kind_of_mark_is_measured_in_window_and_pull_sheet(session):
    mark, control = RowMark("A", 3), session.time
    session.editing.do(replace(session.editing.shot, marks=(mark,)))
    assert control.marks.distances.distance_m(mark) == NEAR_M
    run_until(session, lambda: control.timeline.cache.get(FIRST + 3) is not None, "some frames")
    (track,) = control.mark_tracks()
    assert track.name == "A" and track.lines[0][0] == (FIRST, 1 / NEAR_M)
    control.marks.follow(mark)
    run_until(session, lambda: session.editing.shot.curves.focus_distance_m.keys, "the focus")
    assert session.editing.shot.lens_at(LAST).focus_distance_m == pytest.approx(NEAR_M, rel=1e-3)
    renderer = SimpleNamespace(scene=None, pose_at=lambda shot, frame: None)
    sheet = mark_distances(session.editing.shot, renderer, session.facts.plate, FIRST)
    assert sheet == [("A", NEAR_M)]
