"""Test that tables of a shoot become the lens at each frame, in meters and millimeters."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.focus.plausibility import DepthSpan, focus_unit_doubts
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.main import main
from heatlens.media.camera.camera_file import read_camera
from heatlens.media.camera.into_shot import with_camera
from heatlens.media.documents.shot_file import read_shot
from heatlens.media.plate.header.shoot_names import read_shoot_lens
from support.command_line import stderr_of_run
from support.exr_files import rgb, write_file
from support.shoot_tables import SHOOT_TABLES


@pytest.fixture
def table(tmp_path):
    def write(name: str):
        path = tmp_path / f"{name}.csv"
        path.write_text(SHOOT_TABLES[name])
        return path

    return write


def test_read_camera_of_arri_table_has_meters_and_linear_iris(table):
    camera = read_camera(str(table("arri")))
    assert camera.frames == (0, 1, 2)
    assert camera.focus_distance_m == (4.812, 4.5, 4.1)
    assert camera.focal_length_mm == (40.0,) * 3
    assert camera.f_stop == pytest.approx([1.4 * 2 ** (0.7 / 2)] * 3, rel=5e-3)
    assert camera.frames_per_second == 24.0
    assert "T-stops" in camera.notes[0]


def test_read_camera_of_red_table_has_millimeters(table):
    camera = read_camera(str(table("red")))
    assert camera.focus_distance_m == pytest.approx((0.41, 0.42))
    assert camera.f_stop == (5.6, 5.6)
    assert len(camera.notes) == 1  # no word of a missing unit


def test_read_camera_of_sony_table_has_feet_and_stops(table):
    camera = read_camera(f"{table('sony')}@1001")
    assert camera.frames == (1001, 1002)
    assert camera.focus_distance_m == pytest.approx((5.83 * 0.3048, 5.9 * 0.3048))
    assert camera.f_stop == pytest.approx((2**1.15, 2**1.15))


def test_read_camera_of_own_table_holds_values_over_gaps(table):
    camera = read_camera(str(table("own")))
    assert camera.frames == (1001, 1002, 1004)
    assert camera.focus_distance_m == (2.5, math.inf, 2.0)
    assert camera.f_stop == (2.8, 2.8, 2.8)
    assert camera.focal_length_mm == (35.0, 35.0, 50.0)
    assert camera.notes == ()


def test_with_camera_of_table_keys_only_changing_values(table):
    shot = with_camera(Shot(Lens(50.0, 2.8, 2.0, 36.0)), read_camera(f"{table('arri')}@1001"))
    focus = [shot.lens_at(frame).focus_distance_m for frame in (1001, 1002, 1003)]
    assert focus == pytest.approx([4.812, 4.5, 4.1])
    assert not shot.curves.focal_length_mm.keys and shot.lens.focal_length_mm == 40.0


def test_shot_new_takes_lens_from_shoot_table(table, tmp_path, capsys):
    path = tmp_path / "s.heatlens.json"
    options = ("--lens-from", f"{table('sony')}@1001", "--sensor-width", "36")
    assert main(["shot", "new", "no.####.exr", "-o", str(path), *options]) == 0
    assert read_shot(path).lens_at(1002).focus_distance_m == pytest.approx(5.9 * 0.3048)
    assert "T-stops" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("focus,iris\n", "no rows"),
        ("focus,iris\n--,--\n", "no row has a value"),
        ("frame,focus,iris\nx,1,2\n", "whole numbers"),
        ("frame,focus,iris\n2,1,2\n1,1,2\n", "in order"),
        (f"frame,focus,iris\n{'9' * 400},1,2\n", r"nine digits, got 1\.0+e\+400"),
        ("name,word\na,b\n", "unknown column"),
    ],
)
def test_read_camera_rejects_bad_shoot_table_with_reason(text, reason, tmp_path):
    path = tmp_path / "t.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=reason) as caught:
        read_camera(str(path))
    assert "t.csv" in str(caught.value)


def test_read_camera_of_table_notes_focus_assumed_in_meters(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("frame,focus,f-stop\n1,2.5,2\n")
    camera = read_camera(str(path))
    assert camera.focus_distance_m == (2.5,)
    assert "taken as metres" in camera.notes[0]


def read_table_text(tmp_path, text: str):
    path = tmp_path / "take.csv"
    path.write_text(text)
    return read_camera(str(path))


def test_shoot_table_reads_unit_of_each_cell(tmp_path):
    rows = "1001,6' 3\",2.8\n1005,6ft,2.8\n1010,150cm,2.8\n1011,7,2.8\n"
    camera = read_table_text(tmp_path, f"frame,focus,f-stop\n{rows}")
    assert camera.focus_distance_m == pytest.approx((1.905, 1.8288, 1.5, 7.0))
    assert camera.focus_without_unit_m == ()
    (note,) = camera.notes
    assert "1 of 4 rows" in note and "--table-unit focus=" in note


def test_shoot_table_holds_empty_cells_and_notes_unreadable_ones(tmp_path):
    rows = "1,6' 3\",2.8\n2,7,2.8\n3,,2.8\n4,abc,2.8\n"
    camera = read_table_text(tmp_path, f"frame,focus (ft),f-stop\n{rows}")
    assert camera.focus_distance_m == pytest.approx((1.905, 2.1336, 2.1336, 2.1336))
    (note,) = camera.notes
    assert "'focus (ft)'" in note and "row 5 holds 'abc'" in note and "1 of 3 rows" in note


def test_shoot_table_rejects_mostly_unreadable_column(tmp_path):
    with pytest.raises(InputError, match=r"'focus'.*2 of 3 rows: row 2 holds 'near'") as caught:
        read_table_text(tmp_path, "frame,focus,f-stop\n1,near,2\n2,far,2\n3,2,2\n")
    assert "take.csv" in str(caught.value)


def write_plate_to_depth(path, depth_m):
    """Write a plate with surfaces from 1.2 m to `depth_m`."""
    depth = np.linspace(1.2, depth_m, 24, dtype=np.float32).reshape(4, 6)
    return write_file(path, rgb(4, 6) | {"Z": depth})


@pytest.mark.parametrize(("unit", "expected_name"), [("mm", "millimetres"), ("cm", "centimetres")])
def test_shot_new_warns_of_focus_unit_that_contradicts_plate_depths(
    unit, expected_name, tmp_path, capsys
):
    plate, shot = write_plate_to_depth(tmp_path / "p.1001.exr", 64), tmp_path / "s.heatlens.json"
    per_m = {"mm": 1000, "cm": 100}[unit]
    table = tmp_path / "take.csv"
    table.write_text(f"focus,f-stop\n{2 * per_m},2.8\n{3.15 * per_m},2.8\n")
    words = ["shot", "new", plate, "--lens-from", f"{table}@1001", "-o", shot, "--overwrite"]
    words += ["--focal-length", 50, "--sensor-width", 36]
    stderr = stderr_of_run(capsys, 0, *words)
    assert expected_name in stderr and f"--table-unit focus={unit}." in stderr
    assert f"--table-unit focus={unit}." in stderr_of_run(capsys, 2, *words, "--strict")
    stderr = stderr_of_run(capsys, 0, *words, "--strict", "--table-unit", f"focus={unit}")
    assert "meant" not in stderr and "has no unit" not in stderr
    assert read_shot(shot).lens_at(1001).focus_distance_m == pytest.approx(2.0)


@given(st.lists(st.floats(0.5, 80.0), min_size=1, max_size=5), st.sampled_from(["mm", "cm", "ft"]))
def test_read_shoot_lens_uses_given_unit_unless_cell_has_its_own(distances_m, unit):
    per_m = {"mm": 1000.0, "cm": 100.0, "ft": 1 / 0.3048}[unit]
    for name in ("focus", "focus (m)"):
        for distance_m in distances_m:
            bare = read_shoot_lens({name: f"{distance_m * per_m!r}"}, None, 1 / per_m)
            assert bare.focus_distance_m == pytest.approx(distance_m) and bare.has_unit
            assert read_shoot_lens({name: "150cm"}, None, 1 / per_m).focus_distance_m == 1.5


@given(st.floats(0.1, 1e3), st.floats(1.1, 300.0))
def test_focus_unit_doubts_are_empty_for_focus_within_depths(near_m, times):
    span = DepthSpan(near_m, near_m * times)
    for focus_m in (near_m, near_m * times, near_m * math.sqrt(times), math.inf):
        assert focus_unit_doubts([focus_m], span) == ()
    (warning,) = focus_unit_doubts([1e3 * near_m * math.sqrt(times)], span)
    assert "focus=mm" in warning.sentence


@pytest.mark.parametrize("option", ["'furlong'", "iris=mm"])
def test_shot_new_rejects_unknown_table_unit(option, tmp_path, capsys):
    (tmp_path / "t.csv").write_text("focus,iris\n2000,2.8\n")
    words = ["shot", "new", "no.####.exr", "-o", tmp_path / "s.heatlens.json", "--table-unit"]
    typed = option if "=" in option else f"focus={option[1:-1]}"
    assert option in stderr_of_run(capsys, 2, *words, typed, "--lens-from", tmp_path / "t.csv")
    assert "--lens-from names" in stderr_of_run(capsys, 2, *words, "focus=mm")
    stderr = stderr_of_run(capsys, 2, *words, "focus=mm", "--lens-from", tmp_path / "cam.json")
    assert "is not the table of a shoot" in stderr


def test_shoot_table_notes_unknown_columns(tmp_path):
    path = tmp_path / "take.csv"
    path.write_text("No,FocusPosition [m],IrisF,FocalLength [mm]\n1,2.5,2.8,50\n")
    camera = read_camera(f"{path}@1001")
    assert camera.focal_length_mm == (50.0,) and camera.focus_distance_m is None
    (note,) = camera.notes
    assert "'FocusPosition [m]', 'IrisF', 'No'" in note and "Focus Distance" in note
    path.write_text("Fokus (m);Blende;Brennweite\n2,5;2,8;50\n")
    with pytest.raises(InputError, match=r"no row has a value.*'Fokus \(m\)'.*Focal Length"):
        read_camera(f"{path}@1001")


def test_shoot_table_notes_columns_that_disagree(tmp_path):
    rows = "1000,T1,2.5\n1000,T2.8,2.5\n1000,T4,2.5\n"
    camera = read_table_text(tmp_path, f"Lens Linear Iris,Iris (T-Stop),Focus Distance (m)\n{rows}")
    assert camera.f_stop == (1.0,) * 3
    conflict = next(note for note in camera.notes if "disagree" in note)
    assert "2 of 3 rows" in conflict and "row 3 holds '1000' and 'T2.8'" in conflict
    same = read_table_text(tmp_path, "focus (ft),focus distance (m),iris\n8,2.44,2.8\n20,6.1,2.8\n")
    assert not any("disagree" in note for note in same.notes)


def test_shot_new_reports_where_lens_values_came_from(table, tmp_path, capsys):
    plate = write_plate_to_depth(tmp_path / "p.1001.exr", 64)
    words = ["shot", "new", plate, "-o", tmp_path / "s.heatlens.json", "--overwrite"]
    words += ["--focal-length", 50, "--verbose"]
    take = f"{table('sony')}@1001"
    stderr = stderr_of_run(capsys, 0, *words, "--lens-from", take, "--key", "f-stop@1001=4")
    for words in (f"focus 1.777 m ({take})", "f/4 (--key)", "50 mm (--focal-length)"):
        assert words in stderr
    assert "(--focus-distance)" not in stderr and "(--f-stop)" not in stderr


@pytest.mark.parametrize(
    "text",
    [
        "frame;focus (m);f-stop\n1;4,812;2,8\n2;3,5;2,8\n",
        "frame;focus (m);f-stop\n1;4,812;4\n2;3,500;4\n",
        "frame\tfocus (m)\tf-stop\n1\t4,812\t2,8\n2\t3,500\t2,8\n",
        'frame,focus (m),f-stop\n1,"4,812","2,8"\n2, "3,5", 2\n',
    ],
)
def test_shoot_table_reads_decimal_commas(text, tmp_path):
    assert read_table_text(tmp_path, text).focus_distance_m == (4.812, 3.5)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('frame,focus (mm),f-stop\n1,"1,900",2.8\n', "'1,900', which is not a distance"),
        ("frame,focus,f-stop\n1,2,5,2.8\n", "row 2 has more cells.*decimal comma need"),
    ],
)
def test_shoot_table_rejects_ambiguous_decimal_comma(text, reason, tmp_path):
    with pytest.raises(InputError, match=reason):
        read_table_text(tmp_path, text)
