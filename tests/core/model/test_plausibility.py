"""Test doubts about implausible units, and that plausible shots raise none."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.focus.coc import far_limit_m, near_limit_m
from heatlens.core.model.focus.plausibility import DepthSpan, find_doubts, span_doubts
from heatlens.core.model.lens.lens import Lens

ROOM = DepthSpan(0.76, 11.04)


def joined_doubts(lens, span=ROOM):
    return " ".join(warning.sentence for warning in find_doubts(lens, span))


def lens(focus_m=2.24, focal_mm=50.0, sensor_mm=36.0):
    return Lens(focal_mm, 2.0, focus_m, sensor_mm)


@pytest.mark.parametrize(
    ("doubtful", "span", "cause"),
    [
        (lens(), DepthSpan(76, 1104), "--scene-unit cm"),
        (lens(), DepthSpan(760, 11040), "--scene-unit mm"),
        (lens(), DepthSpan(0.0076, 0.11, unit_m=0.01), "--scene-unit m"),
        (lens(2240.0), ROOM, "--focus-distance 2240mm"),
        (lens(224.0), ROOM, "--focus-distance 224cm"),
        (lens(2240.0), DepthSpan(0.76, 11.04, has_sky=True), "--focus-distance 2240mm"),
        (lens(224.0), DepthSpan(76, 1104), "--scene-unit cm"),  # picked: everything looks sharp
        (lens(focal_mm=0.05), ROOM, "--focal-length 50"),
        (lens(focal_mm=0.05, sensor_mm=0.036), ROOM, "--sensor-width 36"),
        (lens(sensor_mm=1.417), ROOM, "--sensor-width 35.99"),
        (lens(0.2), DepthSpan(4, 4.1), "--focus-at"),
        (lens(focal_mm=3.0), ROOM, "161 degrees"),
        (lens(sensor_mm=3600.0), ROOM, "--sensor-width is in mm"),
    ],
)
def test_doubts_about_wrong_unit_name_option_that_corrects_it(doubtful, span, cause):
    assert cause in joined_doubts(doubtful, span)


@pytest.mark.parametrize(
    ("good", "span"),
    [
        (lens(), ROOM),
        (lens(math.inf), ROOM),
        (lens(0.6), ROOM),  # a little in front of everything, as pulls begin
        (lens(50.0), DepthSpan(0.76, 11.04, has_sky=True)),  # on the sky, or nearly
        (lens(100.0, 2.5, 4.0), DepthSpan(0.5, 80.0, has_sky=True)),  # a phone
        (lens(120.0, 400.0), DepthSpan(60.0, 900.0)),  # a telephoto lens in a landscape
        (Lens(14.0, 8.0, 3.0, 36.0), DepthSpan(1.0, 200.0, has_sky=True)),
        (lens(0.12), DepthSpan(0.1, 0.15)),  # insects
    ],
)
def test_doubts_are_empty_for_usual_shots(good, span):
    assert joined_doubts(good, span) == ""


POSITIVE = st.floats(1e-3, 1e5)


@given(POSITIVE, POSITIVE, POSITIVE, st.floats(8, 600), st.booleans())
def test_focus_between_near_and_far_depth_is_never_doubted(a, b, part, focal_mm, sky):
    near_m, far_m = sorted((a, b))
    focus_m = near_m + (far_m - near_m) * min(part / 1e5, 1.0)
    if focus_m * 1e3 <= focal_mm * 1.01:
        return
    focused = Lens(focal_mm, 2.8, focus_m, 36.0)
    found_doubts = find_doubts(focused, DepthSpan(near_m, far_m, sky))
    assert all(warning.about == "depth" for warning in found_doubts)
    if found_doubts:  # then all of it is sharp, and a room in another unit
        assert near_limit_m(focused) <= near_m and far_limit_m(focused) >= far_m


@given(POSITIVE, POSITIVE)
def test_doubt_about_focus_vanishes_with_suggested_unit(near_m, ratio):
    span = DepthSpan(near_m, near_m * (1 + ratio))
    for warning in find_doubts(lens(), span):
        unit_m = {"cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048, "km": 1e3}.get(
            warning.sentence.partition("--scene-unit ")[2].partition(";")[0].strip(". ")
        )
        if unit_m is not None:
            assert not [d for d in find_doubts(lens(), span.in_unit(unit_m)) if d.about == "focus"]


def test_doubts_are_empty_without_surfaces():
    assert joined_doubts(lens(), DepthSpan(math.inf, math.inf, has_sky=True)) == ""
    assert joined_doubts(lens(), DepthSpan(math.nan, math.nan)) == ""


def test_span_doubts_only_if_another_unit_gives_room_size():
    assert "--scene-unit cm" in span_doubts(DepthSpan(76, 1104))[0].sentence
    assert not span_doubts(ROOM) and not span_doubts(DepthSpan(5e5, 9e5))


@pytest.mark.parametrize(("f_stop", "is_doubted"), [(0.1, True), (0.49, True), (0.5, False)])
def test_doubts_report_f_stop_below_0_5(f_stop, is_doubted):
    found_doubts = find_doubts(Lens(50.0, f_stop, 3.0, 36.0), DepthSpan(1.0, 20.0))
    assert any("faster than f/0.5" in warning.sentence for warning in found_doubts) is is_doubted


@given(st.floats(1.4, 22.0), st.floats(0.8, 11.0), st.booleans())
def test_focus_typed_in_centimeters_is_doubted_at_every_f_stop(f_stop, focus_m, sky):
    typed_m = round(focus_m * 100)
    if typed_m <= 10 * ROOM.far_m:  # nearer than 1.1 m: it could be a distance behind the room
        return
    doubtful = Lens(24.0, f_stop, typed_m, 36.0)
    doubts = joined_doubts(doubtful, DepthSpan(ROOM.near_m, ROOM.far_m, has_sky=sky))
    assert any(f"--focus-distance {typed_m}{unit}." in doubts for unit in ("cm", "mm"))
