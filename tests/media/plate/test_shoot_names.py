"""Test the names that set cameras use for their lens, in headers and in tables."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.units import format_distance, parse_distance_m
from heatlens.media.plate.header.camera_header import camera_at_header
from heatlens.media.plate.header.shoot_names import ShootLens, is_shoot_entry, read_shoot_lens

VALUES = st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=12)
NAMES = st.sampled_from(
    ["Lens Focus Distance", "focus", "Aperture", "Lens Linear Iris", "zoom", "Lens Squeeze", "x"]
)


@pytest.mark.parametrize(
    ("name", "value", "metres"),
    [
        ("Lens Focus Distance", "4.8", 4.8),
        ("Focus Distance (ft)", "10", 3.048),
        ("focus_distance_mm", 1900, 1.9),
        ("com.arri.camera.LensFocusDistance", 4.8, 4.8),
        ("cooke/focusDistance", "inf", math.inf),
        ("zeiss:focus_distance_cm", 250.0, 2.5),
        ("Focus Distance", "0", None),
        ("Focus Distance", "--", None),
        ("Focus Distance", float("nan"), None),
    ],
)
def test_read_shoot_lens_converts_focus_to_meters(name, value, metres):
    focus_m = read_shoot_lens({name: value}).focus_distance_m
    assert focus_m == (None if metres is None else pytest.approx(metres))


def test_read_shoot_lens_takes_unit_from_its_own_entry():
    lens = read_shoot_lens({"LensFocusDistance": 10, "LensDistanceUnit": "Feet"})
    assert (lens.focus_distance_m, lens.has_unit) == (pytest.approx(3.048), True)
    assert not read_shoot_lens({"LensFocusDistance": 10}).has_unit


@pytest.mark.parametrize(
    ("value", "stop"),
    [
        ("2.8", 2.8),
        ("T2.8", 2.8),
        ("f/2.8", 2.8),
        ("1.4 + 7/10", 1.784),
        ("T 2 3/10", 2.219),
        ("T 4", 4.0),
        (4.0, 4.0),
        ("--", None),
        ("closed", None),
        (0, None),
    ],
)
def test_read_shoot_lens_understands_iris_in_any_notation(value, stop):
    t_stop = read_shoot_lens({"Lens Iris": value}).t_stop
    assert t_stop == (None if stop is None else pytest.approx(stop, abs=1e-3))


@given(st.dictionaries(NAMES, VALUES, max_size=6))
def test_read_shoot_lens_of_any_entries_is_possible_or_none(told):
    lens = read_shoot_lens(told)
    for value in (lens.focal_length_mm, lens.f_stop, lens.t_stop, lens.squeeze):
        assert value is None or 0 < value < math.inf
    assert lens.focus_distance_m is None or lens.focus_distance_m > 0


def test_camera_at_header_reads_shoot_names_after_standard_ones():
    arri = {
        "com.arri.camera.LensFocusDistance": 3.2,
        "com.arri.camera.LensFocalLength": 47.0,
        "com.arri.camera.LensIris": "2.8",
    }
    camera = camera_at_header([arri])
    assert (camera.focus_distance_m, camera.focal_length_mm) == (3.2, 47.0)
    assert (camera.f_stop, camera.t_stop) == (2.8, 2.8)
    assert "T-stop" in camera.sources["f_stop"]
    assert "metres" in camera.sources["focus_distance_m"]
    both = camera_at_header([arri | {"focus": 5.0, "aperture": 4.0}])
    assert (both.focus_distance_m, both.f_stop) == (5.0, 4.0)


@pytest.mark.parametrize("name", ["cameraFocalLength", "vrayInfo/camera", "focus", "Iris"])
def test_is_shoot_entry_excludes_names_of_renderers(name):
    assert not is_shoot_entry(name)
    assert camera_at_header([{name: 25.0}]).focal_length_mm is None


@pytest.mark.parametrize(
    ("name", "value", "metres"),
    [
        ("focus", "6' 3\"", 1.905),
        ("focus", "6ft", 1.8288),
        ("focus", "150cm", 1.5),
        ("Focus Distance (m)", "6ft", 1.8288),
        ("Focus Distance (ft)", "2m", 2.0),
        ("Focus Distance [ft]", "10", 3.048),
        ("Focus Distance (ft)", "7", 2.1336),
        ("focus_distance_feet", "10", 3.048),
        ("Lens Focus Distance", "2,5", 2.5),
        ("Lens Focus Distance", "inf", math.inf),
    ],
)
def test_read_shoot_lens_prefers_unit_beside_value(name, value, metres):
    lens = read_shoot_lens({name: value})
    assert lens.focus_distance_m == pytest.approx(metres)
    assert lens.has_unit == (
        not value[-1].isdigit() or name not in ("focus", "Lens Focus Distance")
    )


def test_read_shoot_lens_accepts_focal_length_with_unit_or_comma():
    for name, value in (("zoom", "35,5"), ("zoom", "35.5 mm"), ("Focal Length (cm)", "3,55")):
        assert read_shoot_lens({name: value}).focal_length_mm == pytest.approx(35.5)


@pytest.mark.parametrize("value", ["abc", "-2", "1,900", "6 yards", "2 3", "2.8.1"])
def test_read_shoot_lens_names_unreadable_values(value):
    lens = read_shoot_lens({"Focus Distance": value, "Lens Iris": value, "zoom": value})
    assert lens.unreadable["focus_distance_m"] == "Focus Distance"
    assert set(lens.unreadable) == {"focus_distance_m", "t_stop", "focal_length_mm"}
    assert lens.focus_distance_m is lens.t_stop is lens.focal_length_mm is None


@pytest.mark.parametrize("value", ["", " ", "--", "N/A", "0.000", 0, float("nan"), None])
def test_read_shoot_lens_does_not_call_missing_values_unreadable(value):
    assert not read_shoot_lens({"Focus Distance": value, "Lens Iris": value}).unreadable


@given(st.floats(1e-3, 1e5), st.sampled_from(["m", "ft"]), st.sampled_from(["", " (ft)", " (mm)"]))
def test_read_shoot_lens_reads_back_formatted_distance(distance_m, unit, of_column):
    text = format_distance(distance_m, unit)
    lens = read_shoot_lens({f"Focus Distance{of_column}": text})
    assert lens.has_unit and lens.focus_distance_m == parse_distance_m(text)
    assert lens.focus_distance_m == pytest.approx(distance_m, rel=6e-4, abs=0.0013)


def test_read_shoot_lens_of_no_entries_is_empty():
    assert read_shoot_lens({}) == ShootLens()
    assert (ShootLens().sources, ShootLens().unreadable, ShootLens().conflicts) == ({}, {}, {})
    assert ShootLens().has_unit and ShootLens().focus_distance_m is None
