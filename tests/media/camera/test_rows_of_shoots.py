"""Test which rows, frames, rates and missing values shoot tables give."""

import pytest

from heatlens.core.base.errors import InputError
from heatlens.media.camera.shoot_table import is_shoot_table, read_shoot_table, table_columns
from support.shoot_tables import SHOOT_TABLES


def read_table_text(tmp_path, text, *options):
    path = tmp_path / "take.csv"
    path.write_text(text)
    return read_shoot_table(path, *options)


@pytest.mark.parametrize("name", SHOOT_TABLES)
def test_is_shoot_table_recognizes_tables_of_cameras(tmp_path, name):
    path = tmp_path / "take.csv"
    path.write_text(SHOOT_TABLES[name])
    assert is_shoot_table(table_columns(path))


def test_is_shoot_table_needs_two_lens_columns():
    assert not is_shoot_table(["frame", "Focal Length"]) and not is_shoot_table([])
    assert is_shoot_table(["Focal Length", "Aperture"])


def test_shoot_table_fills_missing_values_from_neighboring_rows(tmp_path):
    text = "frame,Focal Length,Aperture\n5,--,2.8\n6,40,--\n7,--,4\n8,50,\n"
    camera = read_table_text(tmp_path, text)
    assert camera.frames == (5, 6, 7, 8) and camera.name == "take"
    assert camera.focal_length_mm == (40, 40, 40, 50) and camera.f_stop == (2.8, 2.8, 4, 4)
    assert camera.focus_distance_m is None


def test_shoot_table_frames_are_counted_or_read_and_may_be_shifted(tmp_path):
    plain = "Focal Length,Aperture\n40,4\n41,4\n"
    assert read_table_text(tmp_path, plain).frames == (0, 1)
    assert read_table_text(tmp_path, plain, 101).frames == (101, 102)
    with_frames = "Frame,Focal Length,Aperture\n7,40,4\n9,41,4\n"
    assert read_table_text(tmp_path, with_frames).frames == (7, 9)
    assert read_table_text(tmp_path, with_frames, 101).frames == (101, 103)
    with pytest.raises(InputError, match="whole numbers"):
        read_table_text(tmp_path, with_frames.replace("9,", "x,"))


def test_shoot_table_rate_is_that_of_first_row_or_24(tmp_path):
    for rate, expected in (
        ("25", 25.0),
        ("1000", 1000.0),
        ("1001", 24.0),
        ("0", 24.0),
        ("x", 24.0),
    ):
        text = f"Project FPS,Focal Length,Aperture\n{rate},40,4\n50,40,4\n"
        assert read_table_text(tmp_path, text).frames_per_second == expected


def test_shoot_table_keeps_timecodes_if_complete_and_no_first_frame_given(tmp_path):
    text = "Timecode,Focal Length,Aperture\n01:00:00:00,40,4\n01:00:00:01,40,4\n"
    assert [str(timecode) for timecode in read_table_text(tmp_path, text).timecodes] == [
        "01:00:00:00",
        "01:00:00:01",
    ]
    assert read_table_text(tmp_path, text, 5).timecodes is None
    assert read_table_text(tmp_path, text.replace("01:00:00:01", "")).timecodes is None


def test_shoot_table_uses_t_stops_with_a_note(tmp_path):
    camera = read_table_text(tmp_path, SHOOT_TABLES["sony"])
    assert camera.f_stop[0] == pytest.approx(2 * 2 ** (3 / 20), rel=0.2)
    assert camera.notes and camera.focus_distance_m == pytest.approx((5.83 * 0.3048, 5.9 * 0.3048))


def test_shoot_table_focus_without_unit_is_meters_or_given_unit(tmp_path):
    text = "Focal Length,Focus Distance\n40,200\n40,300\n"
    metres = read_table_text(tmp_path, text)
    centimetres = read_table_text(tmp_path, text, None, 0.01)
    assert metres.focus_distance_m == (200, 300) and not metres.has_focus_unit
    assert any("metres" in note for note in metres.notes)
    assert centimetres.focus_distance_m == (2.0, 3.0)


@pytest.mark.parametrize(
    ("text", "word"),
    [("Focal Length,Aperture\n", "no rows"), ("a,b\n1,2\n", "no row has a value of the lens")],
)
def test_read_shoot_table_without_lens_values_raises_error_with_file_name(tmp_path, text, word):
    with pytest.raises(InputError, match=word) as error:
        read_table_text(tmp_path, text)
    assert "take.csv" in str(error.value)
    with pytest.raises(InputError, match=r"none\.csv"):
        read_shoot_table(tmp_path / "none.csv")
