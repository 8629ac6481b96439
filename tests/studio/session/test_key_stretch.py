"""Stretched keys keep the shape of a pull, and each its own frame."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.keys.key_choice import KeyId, all_keys
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.pull import PullShape, shaped_pull
from heatlens.core.model.shot.shot import Shot
from heatlens.studio.board.key_drag import Ends, ends_of, stretch_keys

FOCUS = LensParameter.FOCUS_DISTANCE


def make_pull(shape: PullShape, start=1000, frames=20) -> Shot:
    return shaped_pull(Shot(Lens(50.0, 2.8, 2.0, 36.0)), 2.0, 6.0, start, frames, shape)


@given(st.sampled_from(list(PullShape)), st.integers(1, 6), st.floats(0, 1))
def test_stretch_keys_keeps_the_shape_of_the_curve_of_a_pull(shape, factor, fraction):
    before = make_pull(shape)
    after, chosen = stretch_keys(before, all_keys(before), Ends(1000, 1000 + 20 * factor))
    assert ends_of(chosen) == Ends(1000, 1000 + 20 * factor)
    expected = before.lens_at(1000 + 20 * fraction).focus_distance_m
    focus_m = after.lens_at(1000 + 20 * factor * fraction).focus_distance_m
    assert focus_m == pytest.approx(expected, rel=1e-6)


@given(st.integers(950, 1080))
def test_stretch_keys_keeps_every_key_for_either_dragged_end(frame):
    before = make_pull(PullShape.OVERSHOOT)
    ends = Ends(1000, frame) if frame > 1010 else Ends(min(frame, 1019), 1020)
    after, chosen = stretch_keys(before, all_keys(before), ends)
    assert len(after.curves.focus_distance_m.keys) == len(chosen) == 3
    assert chosen == all_keys(after) and ends_of(chosen) == ends


def test_stretch_keys_keeps_other_keys_and_replaces_key_at_same_frame():
    shot = make_pull(PullShape.EASE).with_key(1030, FOCUS, 3.0).with_key(1060, FOCUS, 4.0)
    chosen = frozenset(KeyId(FOCUS, frame) for frame in (1000.0, 1020.0))
    after, _ = stretch_keys(shot, chosen, Ends(1000, 1030))
    assert [(k.frame, k.value) for k in after.curves.focus_distance_m.keys] == [
        (1000, 2.0), (1030, 6.0), (1060, 4.0),
    ]  # fmt: skip


def test_stretch_keys_leaves_a_single_key_as_it_is():
    shot = Shot(Lens(50.0, 2.8, 2.0, 36.0)).with_key(5, FOCUS, 3.0)
    assert ends_of(all_keys(shot)) is None
    assert stretch_keys(shot, all_keys(shot), Ends(5, 9)) == (shot, all_keys(shot))
