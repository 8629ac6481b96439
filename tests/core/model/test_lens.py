"""Test that a lens rejects impossible values with a clear message."""

import math
from dataclasses import FrozenInstanceError, replace

import pytest

from heatlens.core.base.errors import LensError
from heatlens.core.model.lens.lens import Lens

FIFTY = Lens(focal_length_mm=50.0, f_stop=2.0, focus_distance_m=2.24, sensor_width_mm=36.0)


def test_aperture_diameter_is_focal_length_over_f_stop():
    assert FIFTY.aperture_diameter_mm == 25.0


def test_coc_limit_defaults_to_1_1500th_of_sensor_width():
    assert FIFTY.coc_limit_mm == pytest.approx(0.024, rel=1e-12)
    assert replace(FIFTY, acceptable_coc_mm=0.025).coc_limit_mm == 0.025


def test_lens_compares_by_value_and_is_frozen():
    assert FIFTY == Lens(50.0, 2.0, 2.24, 36.0)
    with pytest.raises(FrozenInstanceError):
        FIFTY.f_stop = 4.0  # type: ignore[misc]


@pytest.mark.parametrize(
    ("field", "words"),
    [
        ("focal_length_mm", "focal length"),
        ("f_stop", "f-stop"),
        ("sensor_width_mm", "sensor width"),
        ("t_stop", "T-stop"),
        ("acceptable_coc_mm", "acceptable circle of confusion"),
    ],
)
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf, -math.inf, 1e-12, 1e12])
def test_lens_rejects_impossible_value_and_names_field(field, words, value):
    with pytest.raises(LensError, match=words) as refusal:
        replace(FIFTY, **{field: value})
    assert f"{value:g}" in str(refusal.value)


@pytest.mark.parametrize("squeeze", [0.0, 0.99, 2.01, -1.0, math.nan, math.inf])
def test_lens_rejects_squeeze_outside_1_to_2(squeeze):
    with pytest.raises(LensError, match="squeeze"):
        replace(FIFTY, squeeze=squeeze)


@pytest.mark.parametrize("focus_distance_m", [0.05, 0.049, 0.0, -3.0, math.nan, -math.inf])
def test_lens_rejects_focus_within_focal_length(focus_distance_m):
    with pytest.raises(LensError, match="focal length of 50 mm") as refusal:
        replace(FIFTY, focus_distance_m=focus_distance_m)
    assert f"{focus_distance_m:g} m" in str(refusal.value)


@pytest.mark.parametrize(
    "change",
    [
        {"focus_distance_m": math.inf},
        {"focus_distance_m": 0.0501},
        {"squeeze": 1.0},
        {"squeeze": 2.0},
        {"t_stop": 1.9},
        {"f_stop": 0.5},
    ],
)
def test_lens_accepts_extreme_valid_values(change):
    lens = replace(FIFTY, **change)
    assert all(getattr(lens, name) == value for name, value in change.items())
