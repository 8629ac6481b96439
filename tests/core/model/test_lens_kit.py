"""Test how a lens kit limits changes of the lens, and the reasons that it gives."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.lens.lens_kit import KitLens, LensCharacter, LensKit

FIFTY, HUNDRED = KitLens(50.0, 2.0, 0.46), KitLens(100.0, 2.5, 0.9, t_stop=2.8)
ZOOM = KitLens(focal_length_mm=24.0, f_stop=2.7, close_focus_m=0.8, longest_mm=70.0)
KIT = LensKit("old", "old primes", (FIFTY, HUNDRED), LensCharacter(squeeze=1.5))
MIXED = LensKit(name="mixed", words="a zoom and a prime", lenses=(ZOOM, HUNDRED))
LENS = Lens(85.0, 1.4, 0.5, 36.0)
LENSES = st.builds(Lens, st.floats(5, 300), st.floats(0.7, 22), st.floats(0.31, 100), st.just(36.0))


@given(LENSES, LENSES, st.sampled_from((KIT, MIXED)))
def test_limit_change_moves_changed_values_into_kit(before, requested_lens, kit):
    kit_lens = kit.limit_change(before, requested_lens)
    lens = kit.nearest(kit_lens.focal_length_mm)
    names = ("focal_length_mm", "f_stop", "focus_distance_m")
    changed = [n for n in names if getattr(before, n) != getattr(requested_lens, n)]
    if "focal_length_mm" in changed:
        assert kit_lens.focal_length_mm == lens.length_near(kit_lens.focal_length_mm)
        assert kit_lens.f_stop >= lens.f_stop and kit_lens.focus_distance_m >= lens.close_focus_m
    assert kit.limit_change(before, kit_lens) == kit_lens or "focal_length_mm" not in changed
    assert (kit.refusal_message(kit_lens) == "") or len(changed) < 3


@given(LENSES, st.sampled_from((KIT, MIXED)))
def test_kit_refusal_is_given_exactly_if_lens_must_change(requested_lens, kit):
    kit_lens = kit.limit_change(None, requested_lens)
    names = ("focal_length_mm", "f_stop", "focus_distance_m")
    is_changed = any(getattr(kit_lens, n) != getattr(requested_lens, n) for n in names)
    assert bool(kit.refusal_message(requested_lens)) == is_changed
    assert kit.refusal_message(kit_lens) == ""


def test_kit_within_mounts_nearest_lens_with_its_character():
    mounted = KIT.limit_lens(LENS)
    assert mounted == replace(mounted, focal_length_mm=100.0, f_stop=2.5, focus_distance_m=0.9)
    assert (mounted.close_focus_m, mounted.squeeze) == (0.9, 1.5)


def test_zoom_of_kit_offers_all_lengths_between_its_ends():
    assert [MIXED.nearest(mm).length_near(mm) for mm in (10, 35, 70, 80, 300)] == [
        *(24.0, 35.0, 70.0),
        *(70.0, 100.0),
    ]
    assert ZOOM.name == "24-70 mm"


def test_limit_change_keeps_unchanged_values_outside_kit():
    keyed = Lens(50.0, 1.0, 5.0, 36.0)
    kit_lens = KIT.limit_change(keyed, replace(keyed, focus_distance_m=0.2))
    assert (kit_lens.f_stop, kit_lens.focus_distance_m) == (1.0, 0.46)


@pytest.mark.parametrize(
    ("requested_lens", "message"),
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
def test_kit_refusal_names_lens_and_its_limit(requested_lens, message):
    assert KIT.refusal_message(requested_lens) == message


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
def test_kit_lens_rejects_impossible_values(values, words):
    with pytest.raises(InputError, match=words):
        KitLens(**{"focal_length_mm": 50.0, "f_stop": 2.0, "close_focus_m": 0.5} | values)


def test_lens_kit_rejects_bad_name_and_equal_lengths():
    for name, lenses in (("two words", (FIFTY,)), ("", (FIFTY,)), ("a", ()), ("a", (FIFTY,) * 2)):
        with pytest.raises(InputError):
            LensKit(name, "", lenses)
    with pytest.raises(InputError, match="squeeze"):
        LensCharacter(squeeze=3.0)
