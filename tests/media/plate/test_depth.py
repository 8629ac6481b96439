"""Test every convention and every mark of infinity of depth channels, with explicit values."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.depth.depth import read_depth
from heatlens.media.plate.depth.depth_guess import NORMALIZED_UP_TO, guess_convention
from heatlens.media.plate.depth.raw_depth import DepthOrigin, measure_raw_depth

INF = math.inf
NAN = math.nan


def read_row(*values, channel="Z", **options):
    """Return the result of `read_depth` for one row of values."""
    row = np.array([values], dtype=np.float32)
    return read_depth(row, f"shot.exr: depth channel {channel!r}", channel, PlateOptions(**options))


def row_m(*values, **options):
    return read_row(*values, **options).values[0].tolist()


@pytest.mark.parametrize("mark", [INF, 1e10, 3.4028234e38, 1e30, 1e6, 65504.0])
def test_read_depth_recognizes_every_mark_of_infinity(mark):
    result = read_row(2, 5, mark, 8)
    assert result.values[0].tolist() == [2, 5, INF, 8]
    assert result.report.infinite_count == 1 and result.report.repaired_count == 0
    assert (result.report.near_m, result.report.far_m) == (2, 8)


@pytest.mark.parametrize("mark", [-INF, -1e10, INF])
def test_read_depth_flips_sign_of_depth_along_minus_z(mark):
    result = read_row(-2, -5, mark, -8)
    assert result.values[0].tolist() == [2, 5, INF, 8]
    assert any("sign" in note for note in result.notes)


def test_read_depth_takes_zero_as_infinity_unless_file_has_another_mark():
    assert row_m(2, 0, 5) == [2, INF, 5]
    result = read_row(2, 0, 1e10, 5, 6)  # 1e10 marks infinity: the 0 is damage
    assert result.values[0].tolist() == [2, 2, INF, 5, 6]
    assert result.report.repaired_count == 1


def test_read_depth_fills_few_bad_values_from_nearest_pixel():
    tail = list(range(10, 60))
    result = read_row(2, NAN, 4, 5, 6, -7, 8, 9, *tail)
    assert result.values[0].tolist() == [2, 2, 4, 5, 6, 6, 8, 9, *tail]
    assert result.report.repaired_count == 2
    assert any("2 of 58 pixels" in note for note in result.notes)


def test_read_depth_takes_many_nan_as_sky_unless_file_has_another_mark():
    result = read_row(2, NAN, NAN, 5, NAN)
    assert result.values[0].tolist() == [2, INF, INF, 5, INF]
    assert any("NaN in 3 of 5 pixels" in note for note in result.notes)
    assert row_m(2, NAN, 3, 5, INF) == [2, 2, 3, 5, INF]


@pytest.mark.parametrize(
    ("unit", "expected"), [(1.0, 250.0), (0.01, 2.5), (0.3048, 76.2), (0.001, 0.25)]
)
def test_read_depth_applies_scene_unit(unit, expected):
    assert row_m(250, 500, scene_unit_m=unit)[0] == pytest.approx(expected)


def test_read_depth_converts_inverse_distance():
    result = read_row(0.5, 0.25, 0, 4, depth_convention="inverse")
    assert result.values[0].tolist() == [2, 4, INF, 0.25]
    assert row_m(-0.5, -0.25, 0, depth_convention="inverse") == [2, 4, INF]
    assert row_m(0.5, 0.25, depth_convention="inverse", scene_unit_m=0.01) == pytest.approx(
        [0.02, 0.04]
    )
    assert row_m(0.5, NAN, INF, 0.25, 0.125, depth_convention="inverse") == [2, 2, 4, 4, 8]


def test_read_depth_converts_normalized_values_of_both_directions():
    ends = {"near_m": 2.0, "far_m": 10.0}
    assert row_m(0, 0.5, 1, depth_convention="normalized", **ends) == [2, 6, INF]
    assert row_m(1, 0.5, 0, depth_convention="normalized-inverted", **ends) == [2, 6, INF]
    assert row_m(-0.1, 0.5, 1.1, depth_convention="normalized", **ends) == [2, 6, INF]
    assert row_m(1.1, 0.5, -0.1, depth_convention="normalized-inverted", **ends) == [2, 6, INF]


def test_plate_options_reject_negative_near_end():
    with pytest.raises(InputError, match=r"near end of the depth .*-1"):
        PlateOptions(near_m=-1.0, far_m=2.0)


@pytest.mark.parametrize("ends", [{}, {"near_m": 1.0}, {"near_m": 5.0, "far_m": 2.0}])
def test_read_depth_normalized_needs_near_and_far(ends):
    with pytest.raises(InputError, match=r"--near.*--far"):
        read_row(0.1, 0.5, depth_convention="normalized", **ends)


def test_read_depth_keeps_signed_circle_of_confusion():
    result = read_row(-12.5, 0, NAN, 30, channel="coc", depth_convention="coc")
    assert result.values[0].tolist() == [-12.5, 0, 0, 30]
    assert result.report.convention == "coc" and result.report.repaired_count == 1


GUESSES = [
    ((1.5, 30, 1e10), {}, "distance"),
    ((0.3, 0.6, 1e10), {}, "distance"),
    ((0.3, 0.6, INF), {}, "distance"),
    ((0, 0.2, 0.6), {}, "inverse"),
    ((0.2, 0.6), {"channel": "disparity.Y"}, "inverse"),
    ((3, -2), {"channel": "coc"}, "coc"),
    ((0.2, 1, 1), {"near_m": 1, "far_m": 9}, "normalized"),
    ((0.2, 0, 0, 1), {"near_m": 1, "far_m": 9}, "normalized-inverted"),
    ((0.2, 0.6), {"near_m": 1, "far_m": 9}, "normalized"),
    ((0.2, 1.01, 1), {"near_m": 1, "far_m": 9}, "normalized"),
    ((0.2, 0.6), {"depth_convention": "distance"}, "distance"),
]


@pytest.mark.parametrize(("values", "options", "convention"), GUESSES)
def test_read_depth_guesses_convention_with_a_reason(values, options, convention):
    report = read_row(*values, **options).report
    assert report.convention == convention
    assert len(report.why) > 20 and report.why.endswith(".")


def test_read_depth_notes_uncertain_guess_of_convention():
    for options, advice in (
        ({}, "If that is wrong: --depth-convention."),
        ({"near_m": 1, "far_m": 9}, "--depth-convention normalized."),
    ):
        (note,) = read_row(0, 0.2, 0.6, **options).notes
        assert note.endswith(advice)
    assert read_row(1.5, 3).notes == ()
    (note,) = read_row(1.5, 3, near_m=1, far_m=9).notes
    assert "--near and --far are not used" in note


@pytest.mark.parametrize("values", [(0.2, 0.6), (0, 0.5, 1), (0.5, 1, 1)])
def test_read_depth_rejects_values_that_fit_several_conventions(values):
    with pytest.raises(InputError, match=r"--depth-convention normalized.*--near.*inverse"):
        read_row(*values)


@pytest.mark.parametrize(
    ("values", "found"), [((0, 0), "zero"), ((NAN, NAN), "NaN"), ((0, NAN), "zero or NaN")]
)
@pytest.mark.parametrize("convention", ["auto", "distance", "inverse", "coc"])
def test_read_depth_rejects_empty_channel(values, found, convention):
    with pytest.raises(InputError, match=rf"empty \(every pixel is {found}\)"):
        read_row(*values, depth_convention=convention)


def test_read_depth_accepts_constant_channel_with_a_note():
    result = read_row(3, 3, 3)
    assert result.values[0].tolist() == [3, 3, 3]
    assert any("3 everywhere" in note for note in result.notes)


def test_read_depth_of_sky_only_is_infinite():
    result = read_row(1e10, 1e10)
    assert result.values[0].tolist() == [INF, INF]
    assert result.report.near_m == result.report.far_m == INF
    assert any("infinite everywhere" in note for note in result.notes)


def test_read_depth_rejects_mixed_signs():
    with pytest.raises(InputError, match=r"not a depth.*--depth-channel"):
        read_row(2, -3, 4, -5)


def test_read_depth_rejects_many_nan_beside_another_mark():
    with pytest.raises(InputError, match="3 of 5 pixels"):
        read_row(2, NAN, NAN, NAN, 1e10)


FLOATS = st.lists(st.floats(width=32), min_size=1, max_size=30)
CONVENTIONS = st.sampled_from(["auto", "distance", "inverse", "normalized", "normalized-inverted"])


@given(FLOATS, CONVENTIONS, st.sampled_from([1.0, 0.001, 0.3048]))
def test_read_depth_of_any_floats_is_positive_or_input_error(values, convention, unit):
    options = {"depth_convention": convention, "scene_unit_m": unit, "near_m": 0.5, "far_m": 20.0}
    try:
        result = read_row(*values, **options)
    except InputError:
        return
    assert (result.values > 0).all()
    assert result.report.infinite_count == np.count_nonzero(np.isinf(result.values))


@given(st.lists(st.floats(1.5, 1e4, width=32), min_size=2, max_size=30))
def test_read_depth_of_inverse_equals_that_of_distance(values):
    inverse = [1 / np.float32(value) for value in values]
    converted_m = row_m(*inverse, depth_convention="inverse")
    assert converted_m == pytest.approx(row_m(*values, depth_convention="distance"), rel=1e-6)


def test_read_depth_mentions_doubtful_zeros_only_once():
    """Zeros are sky in distances or infinity in 1/z; one question names the option."""
    values = np.zeros((20, 20), np.float32)
    values[:3] = np.linspace(1.2, 3, 60, dtype=np.float32).reshape(3, 20)
    result = read_depth(values, "plate.exr: depth channel 'Z'", "Z", PlateOptions())
    assert result.report.question
    assert "taken as infinitely far" in result.notes[0]
    assert sum("--depth-convention inverse" in note for note in result.notes) == 1


@pytest.mark.parametrize("top", [20.0, 20.5, 39.0])
def test_guess_convention_takes_inverse_only_up_to_20(top):
    """A greater 1/z would be nearer than 5 cm, so such a file of Nuke holds distances."""
    row = np.array([[1.5, 2.0, top]], np.float32)
    raw_depth = measure_raw_depth(row, "shot.exr", "depth.Z", DepthOrigin("Nuke"))
    guess = guess_convention(raw_depth, PlateOptions())
    assert guess.convention == ("inverse" if top == 20.0 else "distance")
    assert bool(guess.question) == (top == 20.0)


def test_read_depth_rescales_disparity_only_beyond_its_limit():
    options = {"depth_convention": "disparity", "near_m": 1.0, "far_m": 4.0}
    for largest in (0.5, 1.0, NORMALIZED_UP_TO):
        result = read_row(0.0, 0.5, largest, **options)
        expected_m = [1 / (0.25 + 0.75 * min(value, 1.0)) for value in (0.0, 0.5, largest)]
        assert result.values[0].tolist() == pytest.approx(expected_m) and result.notes == ()
    for values in ((0.0, 1.0, 2.0 * NORMALIZED_UP_TO), (-1.0, 0.0, 1.0)):
        low, middle, high = (
            round(1 / metre, 4) for metre in read_row(*values, **options).values[0]
        )
        assert (low, high) == (0.25, 1.0) and 0.25 < middle < 1.0
        (note,) = read_row(*values, **options).notes
        assert f"{values[0]:g} to {values[2]:g}" in note and "--far and --near" in note
    (note,) = read_row(-1.0, 1.0, **options | {"depth_convention": "disparity-inverted"}).notes
    assert "--near and --far" in note
