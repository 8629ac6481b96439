"""The pull sheet: a row for each key, its timecode, mark and limits, as a page and as a table."""

import csv
import io
from dataclasses import replace

import pytest

from heatlens.model.coc import near_limit_m
from heatlens.model.frames import FrameRange
from heatlens.model.lens import Lens
from heatlens.model.shot import LensParameter, Shot
from heatlens.model.units import parse_distance_m
from heatlens.plate.timecode import Timecode
from heatlens.session.pull_sheet import sheet_csv, sheet_html, sheet_rows, write_sheet

FOCUS = LensParameter.FOCUS_DISTANCE
FRAMES = FrameRange(1001, 1048)
CODE = Timecode(10, 0, 0, 0), 1001


@pytest.fixture
def shot() -> Shot:
    shot = Shot(Lens(50.0, 2.0, 3.0, 36.0), frames_per_second=24.0)
    keys = {1013: 2.0, 1037: 4.0, 1048: 9.0, 2000: 8.0}
    for frame, distance_m in keys.items():
        shot = shot.with_key(frame, FOCUS, distance_m)
    return shot


def marks_at(_frame: float) -> list[tuple[str, float]]:
    return [("Anna", 2.004), ("door <3", 4.0), ("far", 30.0)]


def test_there_is_a_row_for_each_key_and_both_ends(shot):
    rows = sheet_rows(shot, FRAMES, marks_at, CODE)
    assert [row.frame for row in rows] == ["1001", "1013", "1037", "1048"]
    assert [row.mark for row in rows] == ["Anna", "Anna", "door <3", ""]
    assert [row.timecode for row in rows][:3] == ["10:00:00:00", "10:00:00:12", "10:00:01:12"]
    assert rows[1].seconds == "0.50" and rows[1].focus == "2 m"
    assert parse_distance_m(rows[1].near) == pytest.approx(
        near_limit_m(shot.lens_at(1013)), rel=1e-3
    )


def test_without_a_timecode_that_fits_there_is_none(shot):
    assert {row.timecode for row in sheet_rows(shot, FRAMES, marks_at)} == {""}
    late = Timecode(1, 0, 0, 29), 1001
    assert {row.timecode for row in sheet_rows(shot, FRAMES, marks_at, late)} == {""}


def test_a_still_has_one_row(shot):
    still = replace(shot, curves=type(shot.curves)())
    assert len(sheet_rows(still, FrameRange(1, 1), lambda _frame: [])) == 1


def test_the_page_escapes_names_and_the_table_holds_the_same(shot, tmp_path):
    rows = sheet_rows(shot, FRAMES, marks_at, CODE)
    page = sheet_html("rack & <roll>", shot, rows)
    assert "rack &amp; &lt;roll&gt;" in page and "door &lt;3" in page and "<3" not in page
    read = list(csv.DictReader(io.StringIO(sheet_csv(rows))))
    assert [entry["focus"] for entry in read] == [row.focus for row in rows]
    table = write_sheet(tmp_path / "rack.html", "rack", shot, rows)
    assert table == tmp_path / "rack.csv" and table.read_text() == sheet_csv(rows)
