"""Tables of a shoot become the lens at each frame, in metres and millimetres."""

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
from heatlens.media.plate.header.shoot_names import shoot_lens
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


def test_arri_tells_metres_and_a_linear_iris(table):
    camera = read_camera(str(table("arri")))
    assert camera.frames == (0, 1, 2)
    assert camera.focus_distance_m == (4.812, 4.5, 4.1)
    assert camera.focal_length_mm == (40.0,) * 3
    assert camera.f_stop == pytest.approx([1.4 * 2 ** (0.7 / 2)] * 3, rel=5e-3)
    assert camera.frames_per_second == 24.0
    assert "T-stops" in camera.notes[0]


def test_red_tells_millimetres(table):
    camera = read_camera(str(table("red")))
    assert camera.focus_distance_m == pytest.approx((0.41, 0.42))
    assert camera.f_stop == (5.6, 5.6)
    assert len(camera.notes) == 1  # no word of a missing unit


def test_sony_tells_feet_and_stops_from_one(table):
    camera = read_camera(f"{table('sony')}@1001")
    assert camera.frames == (1001, 1002)
    assert camera.focus_distance_m == pytest.approx((5.83 * 0.3048, 5.9 * 0.3048))
    assert camera.f_stop == pytest.approx((2**1.15, 2**1.15))


def test_any_table_with_such_columns_is_read_and_gaps_are_held(table):
    camera = read_camera(str(table("own")))
    assert camera.frames == (1001, 1002, 1004)
    assert camera.focus_distance_m == (2.5, math.inf, 2.0)
    assert camera.f_stop == (2.8, 2.8, 2.8)
    assert camera.focal_length_mm == (35.0, 35.0, 50.0)
    assert camera.notes == ()


def test_what_moves_becomes_keys(table):
    shot = with_camera(Shot(Lens(50.0, 2.8, 2.0, 36.0)), read_camera(f"{table('arri')}@1001"))
    focus = [shot.lens_at(frame).focus_distance_m for frame in (1001, 1002, 1003)]
    assert focus == pytest.approx([4.812, 4.5, 4.1])
    assert not shot.curves.focal_length_mm.keys and shot.lens.focal_length_mm == 40.0


def test_a_shot_begins_with_the_lens_of_a_table(table, tmp_path, capsys):
    path = tmp_path / "s.heatlens.json"
    told = ("--lens-from", f"{table('sony')}@1001", "--sensor-width", "36")
    assert main(["shot", "new", "no.####.exr", "-o", str(path), *told]) == 0
    assert read_shot(path).lens_at(1002).focus_distance_m == pytest.approx(5.9 * 0.3048)
    assert "T-stops" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("focus,iris\n", "no rows"),
        ("focus,iris\n--,--\n", "no row has a value"),
        ("frame,focus,iris\nx,1,2\n", "whole numbers"),
        ("frame,focus,iris\n2,1,2\n1,1,2\n", "in order"),
        (f"frame,focus,iris\n{'9' * 400},1,2\n", r"nine digits, got 1\.0+e\+400"),
        ("name,word\na,b\n", "unknown column"),
    ],
)
def test_a_table_that_is_none_is_explained(text, told, tmp_path):
    path = tmp_path / "t.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=told) as caught:
        read_camera(str(path))
    assert "t.csv" in str(caught.value)


def test_a_distance_without_a_unit_is_taken_for_metres_and_that_is_said(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("frame,focus,f-stop\n1,2.5,2\n")
    camera = read_camera(str(path))
    assert camera.focus_distance_m == (2.5,)
    assert "taken as metres" in camera.notes[0]


def written(tmp_path, text: str):
    path = tmp_path / "take.csv"
    path.write_text(text)
    return read_camera(str(path))


def test_each_cell_may_have_its_own_unit(tmp_path):
    rows = "1001,6' 3\",2.8\n1005,6ft,2.8\n1010,150cm,2.8\n1011,7,2.8\n"
    camera = written(tmp_path, f"frame,focus,f-stop\n{rows}")
    assert camera.focus_distance_m == pytest.approx((1.905, 1.8288, 1.5, 7.0))
    assert camera.focus_without_unit_m == ()
    (said,) = camera.notes
    assert "1 of 4 rows" in said and "--table-unit focus=" in said


def test_only_empty_cells_are_held_and_unreadable_ones_are_named(tmp_path):
    rows = "1,6' 3\",2.8\n2,7,2.8\n3,,2.8\n4,abc,2.8\n"
    camera = written(tmp_path, f"frame,focus (ft),f-stop\n{rows}")
    assert camera.focus_distance_m == pytest.approx((1.905, 2.1336, 2.1336, 2.1336))
    (note,) = camera.notes
    assert "'focus (ft)'" in note and "row 5 holds 'abc'" in note and "1 of 3 rows" in note


def test_a_column_that_is_mostly_unreadable_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"'focus'.*2 of 3 rows: row 2 holds 'near'") as caught:
        written(tmp_path, "frame,focus,f-stop\n1,near,2\n2,far,2\n3,2,2\n")
    assert "take.csv" in str(caught.value)


def plate_at(path, depth_m):
    """Write a plate with surfaces from 1.2 m to `depth_m`."""
    depth = np.linspace(1.2, depth_m, 24, dtype=np.float32).reshape(4, 6)
    return write_file(path, rgb(4, 6) | {"Z": depth})


@pytest.mark.parametrize(("unit", "named"), [("mm", "millimetres"), ("cm", "centimetres")])
def test_a_focus_in_a_smaller_unit_is_doubted_before_the_depths_of_the_plate(
    unit, named, tmp_path, capsys
):
    plate, shot = plate_at(tmp_path / "p.1001.exr", 64), tmp_path / "s.heatlens.json"
    per_m = {"mm": 1000, "cm": 100}[unit]
    table = tmp_path / "take.csv"
    table.write_text(f"focus,f-stop\n{2 * per_m},2.8\n{3.15 * per_m},2.8\n")
    words = ["shot", "new", plate, "--lens-from", f"{table}@1001", "-o", shot, "--overwrite"]
    words += ["--focal-length", 50, "--sensor-width", 36]
    said = stderr_of_run(capsys, 0, *words)
    assert named in said and f"--table-unit focus={unit}." in said
    assert f"--table-unit focus={unit}." in stderr_of_run(capsys, 2, *words, "--strict")
    said = stderr_of_run(capsys, 0, *words, "--strict", "--table-unit", f"focus={unit}")
    assert "meant" not in said and "has no unit" not in said
    assert read_shot(shot).lens_at(1001).focus_distance_m == pytest.approx(2.0)


@given(st.lists(st.floats(0.5, 80.0), min_size=1, max_size=5), st.sampled_from(["mm", "cm", "ft"]))
def test_the_unit_that_a_person_says_counts_but_not_over_one_beside_a_number(told_m, unit):
    per_m = {"mm": 1000.0, "cm": 100.0, "ft": 1 / 0.3048}[unit]
    for name in ("focus", "focus (m)"):
        for distance_m in told_m:
            bare = shoot_lens({name: f"{distance_m * per_m!r}"}, None, 1 / per_m)
            assert bare.focus_distance_m == pytest.approx(distance_m) and bare.has_unit
            assert shoot_lens({name: "150cm"}, None, 1 / per_m).focus_distance_m == 1.5


@given(st.floats(0.1, 1e3), st.floats(1.1, 300.0))
def test_a_focus_among_the_surfaces_is_in_no_doubt(near_m, times):
    span = DepthSpan(near_m, near_m * times)
    for focus_m in (near_m, near_m * times, near_m * math.sqrt(times), math.inf):
        assert focus_unit_doubts([focus_m], span) == ()
    (doubt,) = focus_unit_doubts([1e3 * near_m * math.sqrt(times)], span)
    assert "focus=mm" in doubt.sentence


@pytest.mark.parametrize("option", ["'furlong'", "iris=mm"])
def test_a_unit_that_is_none_is_refused(option, tmp_path, capsys):
    (tmp_path / "t.csv").write_text("focus,iris\n2000,2.8\n")
    words = ["shot", "new", "no.####.exr", "-o", tmp_path / "s.heatlens.json", "--table-unit"]
    typed = option if "=" in option else f"focus={option[1:-1]}"
    assert option in stderr_of_run(capsys, 2, *words, typed, "--lens-from", tmp_path / "t.csv")
    assert "--lens-from names" in stderr_of_run(capsys, 2, *words, "focus=mm")
    said = stderr_of_run(capsys, 2, *words, "focus=mm", "--lens-from", tmp_path / "cam.json")
    assert "is not a shoot table" in said


def test_columns_that_are_not_understood_are_named(tmp_path):
    path = tmp_path / "take.csv"
    path.write_text("No,FocusPosition [m],IrisF,FocalLength [mm]\n1,2.5,2.8,50\n")
    camera = read_camera(f"{path}@1001")
    assert camera.focal_length_mm == (50.0,) and camera.focus_distance_m is None
    (note,) = camera.notes
    assert "'FocusPosition [m]', 'IrisF', 'No'" in note and "Focus Distance" in note
    path.write_text("Fokus (m);Blende;Brennweite\n2,5;2,8;50\n")
    with pytest.raises(InputError, match=r"no row has a value.*'Fokus \(m\)'.*Focal Length"):
        read_camera(f"{path}@1001")


def test_two_columns_that_disagree_are_told(tmp_path):
    rows = "1000,T1,2.5\n1000,T2.8,2.5\n1000,T4,2.5\n"
    camera = written(tmp_path, f"Lens Linear Iris,Iris (T-Stop),Focus Distance (m)\n{rows}")
    assert camera.f_stop == (1.0,) * 3
    conflict = next(note for note in camera.notes if "disagree" in note)
    assert "2 of 3 rows" in conflict and "row 3 holds '1000' and 'T2.8'" in conflict
    same = written(tmp_path, "focus (ft),focus distance (m),iris\n8,2.44,2.8\n20,6.1,2.8\n")
    assert not any("disagree" in note for note in same.notes)


def test_where_values_came_from_is_told(table, tmp_path, capsys):
    plate = plate_at(tmp_path / "p.1001.exr", 64)
    words = ["shot", "new", plate, "-o", tmp_path / "s.heatlens.json", "--overwrite"]
    words += ["--focal-length", 50]
    take = f"{table('sony')}@1001"
    said = stderr_of_run(capsys, 0, *words, "--lens-from", take, "--key", "f-stop@1001=4")
    for words in (f"focus 1.777 m ({take})", "f/4 (--key)", "length 50 mm (--focal-length)"):
        assert words in said
    assert "(--focus-distance)" not in said and "(--f-stop)" not in said


@pytest.mark.parametrize(
    "text",
    [
        "frame;focus (m);f-stop\n1;4,812;2,8\n2;3,5;2,8\n",
        "frame;focus (m);f-stop\n1;4,812;4\n2;3,500;4\n",
        "frame\tfocus (m)\tf-stop\n1\t4,812\t2,8\n2\t3,500\t2,8\n",
        'frame,focus (m),f-stop\n1,"4,812","2,8"\n2, "3,5", 2\n',
    ],
)
def test_decimal_commas_are_read(text, tmp_path):
    assert written(tmp_path, text).focus_distance_m == (4.812, 3.5)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('frame,focus (mm),f-stop\n1,"1,900",2.8\n', "'1,900', which is not a distance"),
        ("frame,focus,f-stop\n1,2,5,2.8\n", "row 2 has more cells.*decimal comma need"),
    ],
)
def test_a_comma_that_may_be_another_is_not_guessed(text, reason, tmp_path):
    with pytest.raises(InputError, match=reason):
        written(tmp_path, text)
