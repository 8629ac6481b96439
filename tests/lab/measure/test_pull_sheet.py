"""Test the pull sheet: rows of focus keys with timecode, mark and limits, as page and table."""

import base64
import csv
import html
import io
import re
from dataclasses import replace
from itertools import zip_longest

import numpy as np
import pytest
from PIL import Image

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.coc import near_limit_m
from heatlens.core.model.lens.lens import Lens, MeasuredFrom
from heatlens.core.model.marks.marks import DistanceMark, PointMark
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.reel import Reel, ReelShot
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.timecode import Timecode
from heatlens.core.model.units import parse_distance_m
from heatlens.deliver.export.sheet_page import Sheet, SheetEntry, data_uri, sheet_html, write_sheet
from heatlens.deliver.export.sheet_rows import mark_rows, sheet_csv, sheet_frames, sheet_row
from heatlens.fronts.commands.main import main
from heatlens.media.documents.reel_file import write_reel
from heatlens.media.documents.shot_file import read_shot, write_shot
from support.sequences import sequence_files

FOCUS = LensParameter.FOCUS_DISTANCE
FRAMES = FrameRange(1001, 1048)
MARKS = [("Anna", 2.004), ("door <3", 4.0), ("far", 30.0)]


@pytest.fixture
def shot() -> Shot:
    shot = Shot(Lens(50.0, 2.0, 3.0, 36.0), frames_per_second=24.0, frames=FRAMES)
    keys = {1013: 2.0, 1037: 4.0, 1048: 9.0, 2000: 8.0}
    for frame, distance_m in keys.items():
        shot = shot.with_key(frame, FOCUS, distance_m)
    return shot


def rows_of(shot):
    frames = sheet_frames(shot, FRAMES)
    return [
        sheet_row(shot, frame, FRAMES.first, MARKS, shot.timecode_at(int(frame)), next_frame)
        for frame, next_frame in zip_longest(frames, frames[1:])
    ]


def test_sheet_has_row_for_each_key_and_both_ends(shot):
    rows = rows_of(replace(shot, start_timecode="10:00:00:00"))
    assert [row.frame for row in rows] == ["1001", "1013", "1037", "1048"]
    assert [row.mark for row in rows] == ["Anna", "Anna", "door <3", ""]
    assert [row.timecode for row in rows][:3] == ["10:00:00:00", "10:00:00:12", "10:00:01:12"]
    assert rows[1].seconds == "0.50" and rows[1].focus == "2 m"
    assert parse_distance_m(rows[1].near) == pytest.approx(
        near_limit_m(shot.lens_at(1013)), rel=1e-3
    )


def test_pull_sheet_gives_limits_in_feet_and_measured_origin(shot):
    film_shot = replace(shot, lens=replace(shot.lens, measured_from=MeasuredFrom.FILM))
    for row in rows_of(film_shot):
        for metres, feet in ((row.near, row.near_feet), (row.far, row.far_feet)):
            assert parse_distance_m(feet) == pytest.approx(parse_distance_m(metres), abs=0.01)
    sheet = Sheet("rack", film_shot, [SheetEntry(row) for row in rows_of(film_shot)])
    page = sheet_html("rack", [sheet])
    assert f"distances: from the {MeasuredFrom.FILM.words}" in page
    assert rows_of(film_shot)[0].near_feet in html.unescape(page)


def test_sheet_row_gives_frames_to_next_key_and_hold(shot):
    assert [row.to_next for row in rows_of(shot)] == [
        "hold 12 frames",
        "24 frames",
        "11 frames",
        "",
    ]
    there_and_back = shot.with_key(1025, FOCUS, 2.0)
    assert [row.to_next for row in rows_of(there_and_back)][1:3] == ["hold 12 frames", "12 frames"]
    far_row = sheet_row(shot, 1_234_567.0, 1, (), None, 1_234_568.0)
    assert (far_row.frame, far_row.to_next) == ("1234567", "hold 1 frame")


def test_sheet_page_lists_marks_and_zoom_range(shot):
    ball = PointMark("ball", 1.0, 1.0)
    marked_shot = replace(
        shot, marks=(DistanceMark("Anna", 2.0), ball, PointMark("gone", 9.0, 9.0))
    )
    distances_per_frame = [[("Anna", 2.0), ("ball", 3.0)], [("Anna", 2.0), ("ball", 1.5)]]
    rows = mark_rows(marked_shot, distances_per_frame)
    assert [(row.name, row.distance) for row in rows] == [("Anna", "2 m"), ("ball", "1.5 m to 3 m")]
    zoom = marked_shot.with_key(1020, LensParameter.FOCAL_LENGTH, 24.0)
    zoom = zoom.with_key(1040, LensParameter.FOCAL_LENGTH, 80.0)
    entries = [SheetEntry(row, marks=tuple(distances_per_frame[0])) for row in rows_of(zoom)]
    page = sheet_html("rack", [Sheet(title="rack", shot=zoom, entries=entries)])
    assert "24 mm to 80 mm" in page and "all marks" in page
    plain_sheet = Sheet(title="rack", shot=shot, entries=[SheetEntry(row) for row in rows_of(shot)])
    assert "all marks" not in sheet_html("rack", [plain_sheet])


def test_timecode_at_prefers_start_of_shot_to_header(shot):
    header_timecode = Timecode(hours=1, minutes=0, seconds=0, frames=12)
    assert shot.timecode_at(1013) is None
    assert shot.timecode_at(1013, header_timecode) == header_timecode
    assert shot.timecode_at(1013, Timecode(hours=1, minutes=0, seconds=0, frames=29)) is None
    started_shot = replace(shot, start_timecode="09:59:59:23")
    assert str(started_shot.timecode_at(1002, header_timecode)) == "10:00:00:00"
    with pytest.raises(InputError, match="not a timecode"):
        replace(shot, start_timecode="25:00:00:00")


def test_start_timecode_survives_shot_file(shot, tmp_path):
    for start in (None, "10:00:00;00"):
        saved_shot = replace(shot, start_timecode=start)
        write_shot(tmp_path / "s.heatlens.json", saved_shot)
        assert read_shot(tmp_path / "s.heatlens.json") == saved_shot


def test_sheet_frames_of_still_are_one_frame(shot):
    assert sheet_frames(replace(shot, curves=type(shot.curves)()), FrameRange(1, 1)) == [1.0]


def test_sheet_page_escapes_names_and_csv_has_same_rows(shot, tmp_path):
    rows = rows_of(shot)
    sheet = Sheet(title="rack & <roll>", shot=shot, entries=[SheetEntry(row) for row in rows])
    page = sheet_html(sheet.title, [sheet])
    assert "rack &amp; &lt;roll&gt;" in page and "door &lt;3" in page and "<3" not in page
    csv_rows = list(csv.DictReader(io.StringIO(sheet_csv(rows))))
    assert [entry["focus"] for entry in csv_rows] == [row.focus for row in rows]
    table = write_sheet(tmp_path / "rack.html", "rack", [sheet])
    assert table == tmp_path / "rack.csv" and table.read_text() == sheet_csv(rows)


def picture_in(uri: str) -> Image.Image:
    return Image.open(io.BytesIO(base64.b64decode(uri.partition(",")[2])))


def test_data_uri_scales_picture_to_480_pixels():
    picture = picture_in(data_uri(np.full((540, 960, 3), 0.5, np.float32)))
    assert picture.size == (480, 270) and picture.getpixel((0, 0)) == (128, 128, 128)


def test_shot_sheet_writes_pictures_marks_and_timecode(tmp_path, capsys):
    pattern = sequence_files(tmp_path, 1001, 1004)
    shot = Shot(
        Lens(50.0, 2.0, 3.0, 36.0),
        source=pattern,
        marks=(DistanceMark("Anna", 2.0), PointMark("ball", 60.0, 32.0)),
        frames=FrameRange(1001, 1004),
    ).with_key(1002, FOCUS, 2.0)
    path = tmp_path / "rack.heatlens.json"
    write_shot(path, shot.with_key(1004, FOCUS, 6.0))
    words = ["shot", "sheet", str(path), "-o", str(tmp_path / "pull.html")]
    assert main([*words, "--start-timecode", "10:00:00:00"]) == 0
    page = (tmp_path / "pull.html").read_text()
    pictures = [picture_in(uri) for uri in re.findall(r'src="(data:[^"]+)"', page)]
    assert len(pictures) == 3
    assert len({picture.tobytes() for picture in pictures}) == 3  # the focus moves
    rows = list(csv.DictReader(io.StringIO((tmp_path / "pull.csv").read_text())))
    assert [row["timecode"] for row in rows] == ["10:00:00:00", "10:00:00:01", "10:00:00:03"]
    assert rows[1]["mark"] == "Anna" and rows[0]["mark"] == "Anna"
    captured = capsys.readouterr()
    assert captured.out.split() == [words[-1], str(tmp_path / "pull.csv")]
    assert captured.err == ""  # progress is for terminals


def test_shot_sheet_of_reel_writes_pdf_with_page_per_shot(tmp_path, capsys):
    from pypdf import PdfReader  # here: costs every worker a second to collect

    pattern, shots = sequence_files(tmp_path, 1001, 1004), []
    for name, near_m in (("first", 2.0), ("second", 5.0)):
        shot = Shot(Lens(50.0, 2.0, 3.0, 36.0), source=pattern, frames=FrameRange(1001, 1004))
        path = tmp_path / f"{name}.heatlens.json"
        write_shot(path, shot.with_key(1002, FOCUS, near_m).with_key(1004, FOCUS, 6.0))
        shots.append(ReelShot(name, source=str(path), frames=FrameRange(1002, 1004)))
    reel = tmp_path / "cut.heatreel.json"
    write_reel(reel, Reel("cut", (*shots, ReelShot("plain", pattern))))
    pages = tmp_path / "pulls.pdf"
    assert main(["shot", "sheet", str(reel), "-o", str(pages)]) == 0
    assert "plain: " in (message := capsys.readouterr().err) and "has no pull" in message
    rows = list(csv.DictReader(io.StringIO((tmp_path / "pulls.csv").read_text())))
    assert [(row["shot"], row["frame"], row["focus"]) for row in rows] == [
        *(("first", "1002", "2 m"), ("first", "1004", "6 m")),
        *(("second", "1002", "5 m"), ("second", "1004", "6 m")),
    ]
    texts = [page.extract_text() for page in PdfReader(pages).pages]
    assert len(texts) == 2 and "first" in texts[0] and "second" in texts[1] and "5 m" in texts[1]
    assert all(len(page.images) >= 2 for page in PdfReader(pages).pages)
    write_reel(reel, Reel("cut", (ReelShot("plain", pattern),)))
    assert main(["shot", "sheet", str(reel), "-o", str(pages)]) == 2


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["-o", "pull.doc"], "must end in .html or .pdf"),
        (["-o", "pull.html", "--start-timecode", "ten"], "not a timecode"),
    ],
)
def test_shot_sheet_rejects_wrong_format_and_timecode(shot, tmp_path, capsys, words, message):
    path = tmp_path / "s.heatlens.json"
    write_shot(path, shot)
    words = [str(tmp_path / word) if word.startswith("pull") else word for word in words]
    assert main(["shot", "sheet", str(path), *words]) == 2
    assert message in capsys.readouterr().err
