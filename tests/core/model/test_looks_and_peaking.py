"""Looks, focus peaking and view states: their names, ranges and defaults."""

from string import ascii_uppercase

import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.mark import free_letter
from heatlens.core.model.shot.look import Look, check_looks
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.guides import (
    BLUR_RANGE,
    PEAKING_COLORS,
    STOPS_RANGE,
    Guides,
    Peaking,
    PeakingOn,
)
from heatlens.core.model.view.view import Against, Compare, ViewState

LENS = Lens(50.0, 2.0, 2.0, 36.0)


@pytest.mark.parametrize("name", ["", " A", "A ", "A\n", "\t"])
def test_look_rejects_empty_or_padded_name(name):
    with pytest.raises(InputError, match="A look needs a name"):
        Look(name, LENS)


def test_look_rejects_too_long_or_non_ascii_still():
    assert Look("A", LENS, still="x" * 100_000).still and Look("A", LENS).still is None
    for wrong in ("x" * 100_001, "ü"):
        with pytest.raises(InputError, match="picture of look A"):
            Look("A", LENS, still=wrong)


def test_free_letter_goes_from_a_to_z_then_a1():
    looks: list[Look] = []
    while len(looks) < 54:
        looks.append(Look(free_letter(look.name for look in looks), LENS))
    names = [look.name for look in looks]
    assert names[:26] == list(ascii_uppercase) and names[25:28] == ["Z", "A1", "B1"]
    assert names[52:] == ["A2", "B2"]
    assert free_letter(look.name for look in looks[1:]) == "A"  # the first that is free


def test_check_looks_rejects_duplicate_names():
    check_looks([Look("A", LENS), Look("B", LENS)])
    with pytest.raises(InputError, match="B"):
        check_looks([Look("A", LENS), Look("B", LENS), Look("B", LENS)])
    with pytest.raises(InputError, match="A"):
        Shot(LENS, looks=(Look("A", LENS),) * 2)


def test_shot_through_look_uses_its_lens_at_every_frame():
    look_lens = Lens(85.0, 1.4, 3.0, 36.0)
    shot = Shot(LENS).with_lens_value(1, "focus_distance_m", 2.0)
    keyed = shot.with_key(1, "focus_distance_m", 5.0).with_key(9, "focus_distance_m", 8.0)
    shot_through_look = keyed.with_look(Look("A", look_lens))
    assert [shot_through_look.lens_at(frame) for frame in (1, 5, 9)] == [
        look_lens
    ] * 3 and not shot_through_look.key_frames


def test_peaking_checks_ranges_and_colors():
    assert (STOPS_RANGE, BLUR_RANGE) == ((0.05, 3.0), (0.1, 4.0))
    default_peaking = Peaking()
    assert (default_peaking.on, default_peaking.stops, default_peaking.blur) == (
        PeakingOn.PICTURE,
        0.5,
        1.0,
    )
    assert default_peaking.color == "magenta" and default_peaking.rgb == (1.0, 0.2, 0.75)
    for field, ends in (("stops", STOPS_RANGE), ("blur", BLUR_RANGE)):
        for end, factor in zip(ends, (0.99, 1.01), strict=True):
            assert getattr(Peaking(**{field: end}), field) == end
            with pytest.raises(InputError, match=field):
                Peaking(**{field: end * factor})
    with pytest.raises(InputError, match=r"pink.*magenta"):
        Peaking(color="pink")
    for name, rgb in PEAKING_COLORS.items():
        assert Peaking(color=name).rgb == rgb and all(0.1 <= value <= 1.0 for value in rgb)
    assert len(set(PEAKING_COLORS.values())) == len(PEAKING_COLORS) == 6


def test_view_state_defaults_show_whole_unchanged_picture():
    view = ViewState()
    assert view.zoom is view.center_px is None and view.depth_of_field
    assert (view.overlay, view.compare, view.against) == (*("none", Compare.OFF, Against.PINHOLE),)
    assert (view.wipe, view.difference_gain) == (0.5, 4.0)
    assert (view.exposure_stops, view.gamma, view.unit) == (0.0, 1.0, "m")
    assert not view.is_peaking and view.guides == Guides() and view.peaking == Peaking()
    assert not view.has_overlay
    for view_with_overlay in (ViewState(overlay="zones"), ViewState(is_peaking=True)):
        assert view_with_overlay.has_overlay
