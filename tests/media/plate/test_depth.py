"""Every convention and every infinity of depth channels, with the values typed out."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.depth.depth import read_depth
from heatlens.media.plate.depth.depth_guess import (
    NORMALIZED_UP_TO,
    DepthOrigin,
    guess_convention,
    looked_at,
)

INF = math.inf
NAN = math.nan


def read(*values, channel="Z", **options):
    """Return the result for one row of values."""
    row = np.array([values], dtype=np.float32)
    return read_depth(row, f"shot.exr: depth channel {channel!r}", channel, PlateOptions(**options))


def metres(*values, **options):
    return read(*values, **options).values[0].tolist()


@pytest.mark.parametrize("mark", [INF, 1e10, 3.4028234e38, 1e30, 1e6, 65504.0])
def test_every_mark_of_infinity_of_a_distance(mark):
    result = read(2, 5, mark, 8)
    assert result.values[0].tolist() == [2, 5, INF, 8]
    assert result.report.infinite_count == 1 and result.report.repaired_count == 0
    assert (result.report.near_m, result.report.far_m) == (2, 8)


@pytest.mark.parametrize("mark", [-INF, -1e10, INF])
def test_depth_along_minus_z_is_turned(mark):
    result = read(-2, -5, mark, -8)
    assert result.values[0].tolist() == [2, 5, INF, 8]
    assert any("sign" in note for note in result.notes)


def test_zero_is_nothing_hit_unless_the_file_marks_that_otherwise():
    assert metres(2, 0, 5) == [2, INF, 5]
    marked = read(2, 0, 1e10, 5, 6)
    assert marked.values[0].tolist() == [2, 2, INF, 5, 6]
    assert marked.report.repaired_count == 1


def test_few_negative_and_nan_take_the_nearest_value():
    tail = list(range(10, 60))
    result = read(2, NAN, 4, 5, 6, -7, 8, 9, *tail)
    assert result.values[0].tolist() == [2, 2, 4, 5, 6, 6, 8, 9, *tail]
    assert result.report.repaired_count == 2
    assert any("2 of 58 pixels" in note for note in result.notes)


def test_nan_over_much_of_the_frame_is_sky_unless_the_file_marks_that_otherwise():
    result = read(2, NAN, NAN, 5, NAN)
    assert result.values[0].tolist() == [2, INF, INF, 5, INF]
    assert any("NaN in 3 of 5 pixels" in note for note in result.notes)
    assert metres(2, NAN, 3, 5, INF) == [2, 2, 3, 5, INF]


@pytest.mark.parametrize(
    ("unit", "expected"), [(1.0, 250.0), (0.01, 2.5), (0.3048, 76.2), (0.001, 0.25)]
)
def test_scene_unit(unit, expected):
    assert metres(250, 500, scene_unit_m=unit)[0] == pytest.approx(expected)


def test_inverse_distance():
    result = read(0.5, 0.25, 0, 4, depth_convention="inverse")
    assert result.values[0].tolist() == [2, 4, INF, 0.25]
    assert metres(-0.5, -0.25, 0, depth_convention="inverse") == [2, 4, INF]
    assert metres(0.5, 0.25, depth_convention="inverse", scene_unit_m=0.01) == pytest.approx(
        [0.02, 0.04]
    )
    assert metres(0.5, NAN, INF, 0.25, 0.125, depth_convention="inverse") == [2, 2, 4, 4, 8]


def test_normalized_both_ways():
    ends = {"near_m": 2.0, "far_m": 10.0}
    assert metres(0, 0.5, 1, depth_convention="normalized", **ends) == [2, 6, INF]
    assert metres(1, 0.5, 0, depth_convention="normalized-inverted", **ends) == [2, 6, INF]
    assert metres(-0.1, 0.5, 1.1, depth_convention="normalized", **ends) == [2, 6, INF]
    assert metres(1.1, 0.5, -0.1, depth_convention="normalized-inverted", **ends) == [2, 6, INF]


def test_an_end_behind_the_camera_is_refused_whatever_reads_it():
    with pytest.raises(InputError, match=r"near end of the depth .*-1"):
        PlateOptions(near_m=-1.0, far_m=2.0)


@pytest.mark.parametrize("ends", [{}, {"near_m": 1.0}, {"near_m": 5.0, "far_m": 2.0}])
def test_normalized_needs_its_ends(ends):
    with pytest.raises(InputError, match=r"--near.*--far"):
        read(0.1, 0.5, depth_convention="normalized", **ends)


def test_signed_circle_of_confusion_passes_through():
    result = read(-12.5, 0, NAN, 30, channel="coc", depth_convention="coc")
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
def test_guess_of_the_convention_gives_its_reason(values, options, convention):
    report = read(*values, **options).report
    assert report.convention == convention
    assert len(report.why) > 20 and report.why.endswith(".")


def test_a_guess_that_could_be_wrong_is_said_aloud():
    for options in ({}, {"near_m": 1, "far_m": 9}):
        (note,) = read(0, 0.2, 0.6, **options).notes
        assert "a guess, which --depth-convention overrules" in note
    assert read(1.5, 3).notes == ()
    (note,) = read(1.5, 3, near_m=1, far_m=9).notes
    assert "--near and --far are not used" in note


@pytest.mark.parametrize("values", [(0.2, 0.6), (0, 0.5, 1), (0.5, 1, 1)])
def test_what_could_be_several_conventions_is_refused(values):
    with pytest.raises(InputError, match=r"--depth-convention normalized.*--near.*inverse"):
        read(*values)


@pytest.mark.parametrize(
    ("values", "found"), [((0, 0), "zero"), ((NAN, NAN), "NaN"), ((0, NAN), "zero or NaN")]
)
@pytest.mark.parametrize("convention", ["auto", "distance", "inverse", "coc"])
def test_an_empty_channel_is_said(values, found, convention):
    with pytest.raises(InputError, match=rf"empty \(every pixel is {found}\)"):
        read(*values, depth_convention=convention)


def test_a_constant_channel_is_read_with_a_warning():
    result = read(3, 3, 3)
    assert result.values[0].tolist() == [3, 3, 3]
    assert any("3 everywhere" in note for note in result.notes)


def test_a_frame_of_sky_is_infinite_everywhere():
    result = read(1e10, 1e10)
    assert result.values[0].tolist() == [INF, INF]
    assert result.report.near_m == result.report.far_m == INF
    assert any("infinite everywhere" in note for note in result.notes)


def test_mixed_signs_are_no_depth():
    with pytest.raises(InputError, match=r"not a depth.*--depth-channel"):
        read(2, -3, 4, -5)


def test_too_many_nan_are_refused():
    with pytest.raises(InputError, match="3 of 5 pixels"):
        read(2, NAN, NAN, NAN, 1e10)


FLOATS = st.lists(st.floats(width=32), min_size=1, max_size=30)
CONVENTIONS = st.sampled_from(["auto", "distance", "inverse", "normalized", "normalized-inverted"])


@given(FLOATS, CONVENTIONS, st.sampled_from([1.0, 0.001, 0.3048]))
def test_any_floats_become_positive_metres_or_a_sentence(values, convention, unit):
    options = {"depth_convention": convention, "scene_unit_m": unit, "near_m": 0.5, "far_m": 20.0}
    try:
        result = read(*values, **options)
    except InputError:
        return
    assert (result.values > 0).all()
    assert result.report.infinite_count == np.count_nonzero(np.isinf(result.values))


@given(st.lists(st.floats(1.5, 1e4, width=32), min_size=2, max_size=30))
def test_distance_and_inverse_agree(values):
    inverse = [1 / np.float32(value) for value in values]
    back = metres(*inverse, depth_convention="inverse")
    assert back == pytest.approx(metres(*values, depth_convention="distance"), rel=1e-6)


def test_the_doubt_about_zeros_is_told_once():
    """Zeros may be the sky of distances, or infinity as 1/z: one question names the option."""
    values = np.zeros((20, 20), np.float32)
    values[:3] = np.linspace(1.2, 3, 60, dtype=np.float32).reshape(3, 20)
    result = read_depth(values, "plate.exr: depth channel 'Z'", "Z", PlateOptions())
    assert result.report.question
    assert "taken as infinitely far" in result.notes[0]
    assert sum("--depth-convention inverse" in note for note in result.notes) == 1


@pytest.mark.parametrize("top", [20.0, 20.5, 39.0])
def test_only_up_to_20_may_values_be_1_over_z(top):
    """A greater 1/z would be nearer than 5 cm, so that a file of Nuke's holds distances."""
    row = np.array([[1.5, 2.0, top]], np.float32)
    raw = looked_at(row, "shot.exr", "depth.Z", DepthOrigin("Nuke"))
    guess = guess_convention(raw, PlateOptions())
    assert guess.convention == ("inverse" if top == 20.0 else "distance")
    assert bool(guess.question) == (top == 20.0)


def test_disparity_keeps_its_scale_up_to_the_limit_and_beyond_it_has_one_of_its_own():
    options = {"depth_convention": "disparity", "near_m": 1.0, "far_m": 4.0}
    for end in (0.5, 1.0, NORMALIZED_UP_TO):
        result = read(0.0, 0.5, end, **options)
        wanted = [1 / (0.25 + 0.75 * min(value, 1.0)) for value in (0.0, 0.5, end)]
        assert result.values[0].tolist() == pytest.approx(wanted) and result.notes == ()
    for values in ((0.0, 1.0, 2.0 * NORMALIZED_UP_TO), (-1.0, 0.0, 1.0)):
        low, middle, high = (round(1 / metre, 4) for metre in read(*values, **options).values[0])
        assert (low, high) == (0.25, 1.0) and 0.25 < middle < 1.0
        (note,) = read(*values, **options).notes
        assert f"{values[0]:g} to {values[2]:g}" in note and "--far and --near" in note
    (note,) = read(-1.0, 1.0, **options | {"depth_convention": "disparity-inverted"}).notes
    assert "--near and --far" in note
