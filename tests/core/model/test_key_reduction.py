"""Few keys for a recording: never off by more than the tolerance, and few where few do."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.curve import Curve, Key
from heatlens.core.model.curves.interpolation import Ease, Interpolation, Scale
from heatlens.core.model.curves.key_reduction import moving_part, reduced_keys

DISTANCES = st.floats(0.2, 500.0)
TOLERANCES = st.floats(1e-4, 0.5)
SCALES = st.sampled_from(list(Scale))


@st.composite
def recordings(draw, distances=DISTANCES, least=1):
    count = draw(st.integers(least, 40))
    frames = range(draw(st.integers(-50, 1001)), 2000)
    return [(frame, draw(distances)) for frame, _ in zip(frames, range(count), strict=False)]


def off_dioptres(keys, samples, scale=Scale.RECIPROCAL):
    curve = Curve(keys, scale)
    return max(abs(1 / curve.value_at(frame) - 1 / at) for frame, at in samples)


@given(recordings(), TOLERANCES, SCALES)
def test_no_sample_is_missed_by_more_than_the_tolerance(samples, tolerance, scale):
    keys = reduced_keys(samples, tolerance, scale)
    assert off_dioptres(keys, samples, scale) <= tolerance * (1 + 1e-6) + 1e-8


@given(recordings(st.one_of(DISTANCES, st.just(math.inf))), TOLERANCES)
def test_infinity_is_a_place_as_any_other(samples, tolerance):
    keys = reduced_keys(samples, tolerance)
    assert off_dioptres(keys, samples) <= tolerance * (1 + 1e-6) + 1e-8


@given(recordings(least=2), TOLERANCES, SCALES)
def test_keys_lie_on_samples_and_both_ends_are_kept(samples, tolerance, scale):
    keys = reduced_keys(samples, tolerance, scale)
    met = [(key.frame, key.value) for key in keys]
    assert set(met) <= set(samples)
    if len(met) > 1:
        assert (met[0], met[-1]) == (samples[0], samples[-1])


@given(DISTANCES, st.integers(1, 60), TOLERANCES)
def test_a_focus_that_was_not_moved_is_one_key(distance_m, count, tolerance):
    samples = [(frame, distance_m) for frame in range(1001, 1001 + count)]
    assert reduced_keys(samples, tolerance) == (Key(1001, distance_m),)


@given(recordings(), TOLERANCES)
def test_the_curve_never_goes_beyond_the_keys_on_either_side(samples, tolerance):
    curve = Curve(reduced_keys(samples, tolerance), Scale.RECIPROCAL)
    for key, after in pairwise(curve.keys):
        low, high = sorted((key.value, after.value))
        for part in range(1, 8):
            value = curve.value_at(key.frame + (after.frame - key.frame) * part / 8)
            assert low * (1 - 1e-9) <= value <= high * (1 + 1e-9)


@given(DISTANCES, DISTANCES, st.integers(2, 80), st.floats(5, 45), st.floats(5, 45))
def test_an_eased_pull_is_two_keys(near_m, far_m, frames, leaves, arrives):
    if abs(1 / near_m - 1 / far_m) < 0.06:
        far_m = 1 / (1 / near_m + 0.1)
    pull = Curve(
        (
            Key(0, near_m, Interpolation.BEZIER, ease_out=Ease(leaves)),
            Key(frames, far_m, ease_in=Ease(arrives)),
        ),
        Scale.RECIPROCAL,
    )
    samples = [(frame, pull.value_at(frame)) for frame in range(frames + 1)]
    tolerance = 0.05 * abs(1 / near_m - 1 / far_m)
    assert len(reduced_keys(samples, tolerance)) == 2


def test_a_pull_between_two_rests_is_few_keys():
    samples = [(f, 4.0) for f in range(20)]
    samples += [(20 + f, 1 / (0.25 + 0.5 * (f / 24) ** 2 * (3 - 2 * f / 24))) for f in range(25)]
    samples += [(45 + f, 1 / 0.75) for f in range(20)]
    assert len(reduced_keys(samples, 0.01)) <= 4


def test_a_shaking_hand_leaves_fewer_keys_the_more_is_tolerated():
    samples = [
        (f, 1 / (0.5 + 0.3 * math.sin(f / 15) + 0.01 * math.sin(7.3 * f))) for f in range(96)
    ]
    counts = [len(reduced_keys(samples, tolerance)) for tolerance in (0.001, 0.012, 0.05)]
    assert counts == sorted(counts, reverse=True)
    assert counts[1] <= 12


def test_the_last_of_several_samples_at_a_frame_counts_and_order_does_not():
    samples = [(3, 2.0), (1, 9.0), (1, 4.0), (2, 3.0)]
    assert reduced_keys(samples, 0.001)[0] == reduced_keys([(1, 4.0), (2, 3.0), (3, 2.0)], 0.001)[0]
    assert reduced_keys([], 0.1) == ()


@pytest.mark.parametrize("tolerance", [-0.1, math.nan])
def test_a_tolerance_that_is_none_is_refused(tolerance):
    with pytest.raises(InputError, match="tolerance"):
        reduced_keys([(1, 2.0)], tolerance)


@pytest.mark.parametrize("distance_m", [0.0, -1.0, math.nan])
def test_a_distance_that_no_key_can_have_is_refused(distance_m):
    with pytest.raises(InputError):
        reduced_keys([(1, 2.0), (2, distance_m)], 0.1)


@given(recordings(least=2), TOLERANCES)
def test_what_stands_still_at_both_ends_is_left_out(samples, tolerance):
    kept = moving_part(samples, tolerance)
    at = samples.index(kept[0])
    assert samples[at : at + len(kept)] == kept
    for left_out, stays in ((samples[:at], kept[0]), (samples[at + len(kept) :], kept[-1])):
        for _, distance_m in left_out:
            assert abs(1 / distance_m - 1 / stays[1]) <= tolerance * (1 + 1e-9)


def test_a_move_between_two_stands_begins_with_the_last_of_one_and_ends_with_the_first_of_other():
    track = [2.0, 2.0, 2.0, 3.0, 4.0, 4.0, 4.0]
    samples = list(enumerate(track, start=1001))
    assert moving_part(samples, 1e-3) == samples[2:5]
    assert moving_part(samples[:3], 1e-3) == samples[:3]  # nothing moves: all of it
