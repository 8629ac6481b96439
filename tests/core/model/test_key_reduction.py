"""Test the reduction of recorded samples to keys: within the tolerance, and with few keys."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.curve import Curve, Key
from heatlens.core.model.curves.interpolation import Ease, Interpolation, Scale
from heatlens.core.model.curves.key_reduction import reduce_keys, trim_still_ends

DISTANCES = st.floats(0.2, 500.0)
TOLERANCES = st.floats(1e-4, 0.5)
SCALES = st.sampled_from(list(Scale))


@st.composite
def recordings(draw, distances=DISTANCES, least=1):
    count = draw(st.integers(least, 40))
    frames = range(draw(st.integers(-50, 1001)), 2000)
    return [(frame, draw(distances)) for frame, _ in zip(frames, range(count), strict=False)]


def max_error_dioptres(keys, samples, scale=Scale.RECIPROCAL):
    curve = Curve(keys, scale)
    return max(abs(1 / curve.value_at(frame) - 1 / distance_m) for frame, distance_m in samples)


@given(recordings(), TOLERANCES, SCALES)
def test_reduce_keys_stays_within_tolerance_of_samples(samples, tolerance, scale):
    keys = reduce_keys(samples, tolerance, scale)
    assert max_error_dioptres(keys, samples, scale) <= tolerance * (1 + 1e-6) + 1e-8


@given(recordings(st.one_of(DISTANCES, st.just(math.inf))), TOLERANCES)
def test_reduce_keys_handles_samples_at_infinity(samples, tolerance):
    keys = reduce_keys(samples, tolerance)
    assert max_error_dioptres(keys, samples) <= tolerance * (1 + 1e-6) + 1e-8


@given(recordings(least=2), TOLERANCES, SCALES)
def test_reduce_keys_returns_samples_and_both_ends(samples, tolerance, scale):
    keys = reduce_keys(samples, tolerance, scale)
    key_points = [(key.frame, key.value) for key in keys]
    assert set(key_points) <= set(samples)
    if len(key_points) > 1:
        assert (key_points[0], key_points[-1]) == (samples[0], samples[-1])


@given(DISTANCES, st.integers(1, 60), TOLERANCES)
def test_reduce_keys_of_constant_focus_returns_one_key(distance_m, count, tolerance):
    samples = [(frame, distance_m) for frame in range(1001, 1001 + count)]
    assert reduce_keys(samples, tolerance) == (Key(1001, distance_m),)


@given(recordings(), TOLERANCES)
def test_curve_of_reduced_keys_stays_between_neighboring_keys(samples, tolerance):
    curve = Curve(reduce_keys(samples, tolerance), Scale.RECIPROCAL)
    for key, after in pairwise(curve.keys):
        low, high = sorted((key.value, after.value))
        for part in range(1, 8):
            value = curve.value_at(key.frame + (after.frame - key.frame) * part / 8)
            assert low * (1 - 1e-9) <= value <= high * (1 + 1e-9)


@given(DISTANCES, DISTANCES, st.integers(2, 80), st.floats(5, 45), st.floats(5, 45))
def test_reduce_keys_of_eased_pull_returns_two(near_m, far_m, frames, leaves, arrives):
    if abs(1 / near_m - 1 / far_m) < 0.06:
        far_m = 1 / (1 / near_m + 0.1)
    pull = Curve(
        (
            Key(frame=0, value=near_m, interpolation=Interpolation.BEZIER, ease_out=Ease(leaves)),
            Key(frames, far_m, ease_in=Ease(arrives)),
        ),
        Scale.RECIPROCAL,
    )
    samples = [(frame, pull.value_at(frame)) for frame in range(frames + 1)]
    tolerance = 0.05 * abs(1 / near_m - 1 / far_m)
    assert len(reduce_keys(samples, tolerance)) == 2


def test_reduce_keys_of_pull_between_rests_returns_at_most_four():
    samples = [(f, 4.0) for f in range(20)]
    samples += [(20 + f, 1 / (0.25 + 0.5 * (f / 24) ** 2 * (3 - 2 * f / 24))) for f in range(25)]
    samples += [(45 + f, 1 / 0.75) for f in range(20)]
    assert len(reduce_keys(samples, 0.01)) <= 4


def test_larger_tolerance_gives_fewer_keys_for_noisy_focus():
    samples = [
        (f, 1 / (0.5 + 0.3 * math.sin(f / 15) + 0.01 * math.sin(7.3 * f))) for f in range(96)
    ]
    counts = [len(reduce_keys(samples, tolerance)) for tolerance in (0.001, 0.012, 0.05)]
    assert counts == sorted(counts, reverse=True)
    assert counts[1] <= 12


def test_reduce_keys_sorts_samples_and_uses_last_of_each_frame():
    samples = [(3, 2.0), (1, 9.0), (1, 4.0), (2, 3.0)]
    assert reduce_keys(samples, 0.001)[0] == reduce_keys([(1, 4.0), (2, 3.0), (3, 2.0)], 0.001)[0]
    assert reduce_keys([], 0.1) == ()


@pytest.mark.parametrize("tolerance", [-0.1, math.nan])
def test_reduce_keys_rejects_invalid_tolerance(tolerance):
    with pytest.raises(InputError, match="tolerance"):
        reduce_keys([(1, 2.0)], tolerance)


@pytest.mark.parametrize("distance_m", [0.0, -1.0, math.nan])
def test_reduce_keys_rejects_impossible_distance(distance_m):
    with pytest.raises(InputError):
        reduce_keys([(1, 2.0), (2, distance_m)], 0.1)


@given(recordings(least=2), TOLERANCES)
def test_trim_still_ends_omits_constant_ends(samples, tolerance):
    moving_samples = trim_still_ends(samples, tolerance)
    start = samples.index(moving_samples[0])
    assert samples[start : start + len(moving_samples)] == moving_samples
    for omitted, neighbor in (
        (samples[:start], moving_samples[0]),
        (samples[start + len(moving_samples) :], moving_samples[-1]),
    ):
        for _, distance_m in omitted:
            assert abs(1 / distance_m - 1 / neighbor[1]) <= tolerance * (1 + 1e-9)


def test_trim_still_ends_keeps_one_still_sample_at_each_end():
    track = [2.0, 2.0, 2.0, 3.0, 4.0, 4.0, 4.0]
    samples = list(enumerate(track, start=1001))
    assert trim_still_ends(samples, 1e-3) == samples[2:5]
    assert trim_still_ends(samples[:3], 1e-3) == samples[:3]  # nothing moves: all of it
