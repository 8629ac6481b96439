"""A kit bounds what a hand does to the lens, and says why."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.lens.lens_kit import KitLens, LensCharacter, LensKit

FIFTY, HUNDRED = KitLens(50.0, 2.0, 0.46), KitLens(100.0, 2.5, 0.9, t_stop=2.8)
ZOOM = KitLens(24.0, 2.7, 0.8, longest_mm=70.0)
KIT = LensKit("old", "old primes", (FIFTY, HUNDRED), LensCharacter(squeeze=1.5))
MIXED = LensKit("mixed", "a zoom and a prime", (ZOOM, HUNDRED))
LENS = Lens(85.0, 1.4, 0.5, 36.0)
LENSES = st.builds(Lens, st.floats(5, 300), st.floats(0.7, 22), st.floats(0.31, 100), st.just(36.0))


@given(LENSES, LENSES, st.sampled_from((KIT, MIXED)))
def test_what_a_hand_changes_is_within_the_kit(before, asked, kit):
    got = kit.followed(before, asked)
    lens = kit.nearest(got.focal_length_mm)
    names = ("focal_length_mm", "f_stop", "focus_distance_m")
    changed = [n for n in names if getattr(before, n) != getattr(asked, n)]
    if "focal_length_mm" in changed:
        assert got.focal_length_mm == lens.length_near(got.focal_length_mm)
        assert got.f_stop >= lens.f_stop and got.focus_distance_m >= lens.close_focus_m
    assert kit.followed(before, got) == got or "focal_length_mm" not in changed
    assert (kit.refusal(got) == "") or len(changed) < 3


@given(LENSES, st.sampled_from((KIT, MIXED)))
def test_a_refusal_is_told_exactly_where_the_lens_is_changed(asked, kit):
    got = kit.followed(None, asked)
    names = ("focal_length_mm", "f_stop", "focus_distance_m")
    is_changed = any(getattr(got, n) != getattr(asked, n) for n in names)
    assert bool(kit.refusal(asked)) == is_changed
    assert kit.refusal(got) == ""


def test_the_nearest_lens_is_mounted_with_its_character():
    mounted = KIT.within(LENS)
    assert mounted == replace(mounted, focal_length_mm=100.0, f_stop=2.5, focus_distance_m=0.9)
    assert (mounted.close_focus_m, mounted.squeeze) == (0.9, 1.5)


def test_a_zoom_has_every_length_between_its_ends():
    assert [MIXED.nearest(mm).length_near(mm) for mm in (10, 35, 70, 80, 300)] == [
        *(24.0, 35.0, 70.0),
        *(70.0, 100.0),
    ]
    assert ZOOM.name == "24-70 mm"


def test_what_was_outside_before_stays_until_it_is_touched():
    keyed = Lens(50.0, 1.0, 5.0, 36.0)
    got = KIT.followed(keyed, replace(keyed, focus_distance_m=0.2))
    assert (got.f_stop, got.focus_distance_m) == (1.0, 0.46)


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        (Lens(85.0, 2.8, 2.0, 36.0), "The kit old has no 85 mm, only 50, 100 mm."),
        (Lens(50.0, 1.4, 2.0, 36.0), "The 50 mm of the kit old opens to f/2, not to f/1.4."),
        (
            Lens(100.0, 2.8, 0.5, 36.0),
            "The 100 mm of the kit old focuses from 0.9 m, not from 0.5 m.",
        ),
        (Lens(100.0, 2.8, 2.0, 36.0), ""),
    ],
)
def test_a_refusal_names_the_lens_and_its_limit(asked, told):
    assert KIT.refusal(asked) == told


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"focal_length_mm": 0.0}, "focal length"),
        ({"f_stop": 100.0}, "f-stop"),
        ({"close_focus_m": 0.04}, "beyond the focal length"),
        ({"longest_mm": 40.0}, "longest focal length"),
        ({"t_stop": 1.4}, "T-stop"),
        ({"breathing": 3.0}, "breathing"),
    ],
)
def test_a_lens_that_cannot_be_is_refused(values, words):
    with pytest.raises(InputError, match=words):
        KitLens(**{"focal_length_mm": 50.0, "f_stop": 2.0, "close_focus_m": 0.5} | values)


def test_a_kit_needs_a_name_and_lenses_of_different_lengths():
    for name, lenses in (("two words", (FIFTY,)), ("", (FIFTY,)), ("a", ()), ("a", (FIFTY,) * 2)):
        with pytest.raises(InputError):
            LensKit(name, "", lenses)
    with pytest.raises(InputError, match="squeeze"):
        LensCharacter(squeeze=3.0)
