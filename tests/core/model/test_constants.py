"""Spell out documented numbers and the edges of ranges, so that none changes unnoticed."""

import math
from fractions import Fraction

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.curves import interpolation, key_reduction
from heatlens.core.model.curves.frames import (
    FrameRange,
    check_frame,
    check_frames_per_second,
    check_within,
    exact_rate,
)
from heatlens.core.model.curves.interpolation import Ease
from heatlens.core.model.depth_words import DepthConvention, DepthKind
from heatlens.core.model.focus import plausibility
from heatlens.core.model.focus.coc import sharp_px
from heatlens.core.model.focus.plausibility import (
    DepthSpan,
    find_doubts,
    focus_unit_doubts,
    span_doubts,
)
from heatlens.core.model.lens import opening
from heatlens.core.model.lens.lens import THIRD_STOPS, Lens, MeasuredFrom
from heatlens.core.model.lens.lens_kit import KitLens
from heatlens.core.model.shot.framing import Framing, SceneTiming
from heatlens.core.model.shot.history import History
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings, Method, barred_methods
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.value_bins import DepthHistogram, scale_end_dioptres
from heatlens.core.model.view.view import ViewState

LENS = Lens(50.0, 2.0, 2.0, 36.0)


def expect_input_error(make, *words):
    with pytest.raises(InputError) as error:
        make()
    assert all(word in str(error.value) for word in words), error.value


def test_frame_has_at_most_nine_digits_and_rate_at_most_10_000():
    for right in (-999_999_999, 999_999_999, 0.5):
        check_frame(right)
    for wrong in (-1_000_000_000, 1_000_000_000, math.nan):
        expect_input_error(lambda wrong=wrong: check_frame(wrong), "nine digits")
    for rate in (0.001, 10_000.0):
        check_frames_per_second(rate)
    for rate in (0.0, -1.0, 10_000.1, math.nan):
        expect_input_error(lambda rate=rate: check_frames_per_second(rate), "10,000")


def test_check_within_names_first_frame_outside_and_counts_others():
    span = FrameRange(3, 9)
    check_within(span, "a.glb", range(3, 10))
    check_within(None, "a.glb", [-7])
    with pytest.raises(InputError) as error:
        check_within(span, "a.glb", [3, 10])
    assert "a.glb has frames 3 to 9, got 10" in str(error.value) and "more" not in str(error.value)
    expect_input_error(lambda: check_within(span, "a.glb", [1, 2, 5, 10]), "got 1 and 2 more")


@pytest.mark.parametrize(
    ("rate", "exact"),
    [
        (23.976, Fraction(24000, 1001)),
        (23.98, Fraction(24000, 1001)),
        (29.97, Fraction(30000, 1001)),
        (59.94, Fraction(60000, 1001)),
        (24.0, Fraction(24)),
        (25.0, Fraction(25)),
        (12.5, Fraction(25, 2)),
        (23.99, Fraction(2399, 100)),
    ],
)
def test_exact_rate_maps_broadcast_rates_to_fractions(rate, exact):
    assert exact_rate(rate) == exact


def test_scene_timing_and_framing_check_rate_size_and_unit():
    assert SceneTiming(first_frame=999_999_999).frames_per_second == 24.0
    expect_input_error(lambda: SceneTiming(frames_per_second=0.0), "10,000")
    expect_input_error(lambda: SceneTiming(first_frame=1_000_000_000), "nine digits")
    assert Framing().size == (1280, 720) and Framing(1, 16384).size == (1, 16384)
    for wrong in ((0, 720), (1280, 0), (16385, 720), (1280, 16385)):
        expect_input_error(lambda wrong=wrong: Framing(*wrong), "16384", f"{wrong[0]}x{wrong[1]}")
    assert Framing().meters_per_unit == 1.0
    for unit_m in (0.0, -1.0, math.nan, math.inf):
        expect_input_error(lambda unit_m=unit_m: Framing(meters_per_unit=unit_m), "metres")


def test_ease_limits_influence_and_speed_and_clamps_handles():
    assert Ease(0.0).influence_percent == 0.0 and Ease(100.0, 1e9).speed_per_frame == 1e9
    for wrong in ((-0.1,), (100.1,), (math.nan,)):
        expect_input_error(lambda wrong=wrong: Ease(*wrong), "0 to 100 %")
    for speed in (1.01e9, -1.01e9, math.nan):
        expect_input_error(lambda speed=speed: Ease(50.0, speed), "per frame")
    assert Ease.of_handle(frames=2.0, rise=3.0, segment_frames=8.0) == Ease(25.0, 1.5)
    assert Ease(25.0, 1.5).handle(8.0) == (2.0, 3.0)
    assert Ease.of_handle(frames=20.0, rise=3.0, segment_frames=8.0).influence_percent == 100.0
    assert (
        Ease.of_handle(frames=-1.0, rise=3.0, segment_frames=8.0)
        == Ease(0.0)
        == Ease.of_handle(frames=7.9e-6, rise=3.0, segment_frames=8.0)
    )
    assert Ease.of_handle(frames=1e-5, rise=1e9, segment_frames=8.0).speed_per_frame == 1e9
    assert Ease.of_handle(frames=1e-5, rise=-1e9, segment_frames=8.0).speed_per_frame == -1e9
    assert Ease().influence_percent == 100 / 3 and Ease().speed_per_frame == 0.0
    assert (interpolation._HALVINGS, key_reduction._SWEEPS) == (60, 12)


def test_history_keeps_the_last_1000_steps():
    history = History.of(Shot(LENS))
    shots = [Shot(Lens(50.0, 2.0, 2.0 + step / 1000, 36.0)) for step in range(1, 1003)]
    for shot in shots:
        history = history.with_current(shot).end_gesture()
    assert len(history.past) == 1000 and history.past[0] == shots[1 - 0]


def test_sharp_px_transmission_stops_and_words_of_measured_from():
    lens = Lens(50.0, 2.0, 2.0, 36.0, acceptable_coc_mm=0.03)
    assert sharp_px(lens, 1200) == pytest.approx(1.0)
    slow = Lens(50.0, 2.8, 2.0, 36.0, t_stop=2.8 * math.sqrt(2))
    assert slow.transmission_stops == pytest.approx(-1.0) and LENS.transmission_stops == 0.0
    assert ViewState(exposure_stops=0.5).with_transmission(slow).exposure_stops == pytest.approx(
        -0.5
    )
    limits = [ViewState().brighten(stops).exposure_stops for stops in (1e3, -1e3)]
    assert limits == [30.0, -30.0]
    assert MeasuredFrom.FILM.words == "film plane" and MeasuredFrom.PUPIL.words == "entrance pupil"


def test_box_union_and_histogram_position_of_distances():
    assert Box(1, 2, 5, 6).union(Box(3, 0, 4, 9)) == Box(1, 0, 5, 9)
    histogram = DepthHistogram(np.zeros(160), 2.0)
    assert histogram.scale_position(math.inf) == 0.0 and histogram.scale_position(1.0) == 0.5
    assert (
        histogram.scale_position(0.5)
        == 1.0
        == histogram.scale_position(0.1)
        == histogram.scale_position(0.0)
    )
    assert scale_end_dioptres(1.0) > 1.0


def test_kit_lens_describes_its_stop_and_closest_focus():
    spherical = KitLens(focal_length_mm=50.0, f_stop=2.0, close_focus_m=0.45)
    assert spherical.words == "opens to f/2, focuses from 0.45 m" and spherical.name == "50 mm"
    assert "f/2 (T2.2)" in KitLens(50.0, 2.0, 0.45, t_stop=2.2).words


@pytest.mark.parametrize(
    ("convention", "facts"),
    [
        (DepthConvention.AUTO, "takes_ends has_unit"),
        (DepthConvention.DISTANCE, "has_unit"),
        (DepthConvention.INVERSE, "has_unit"),
        (DepthConvention.NORMALIZED, "takes_ends needs_ends"),
        (DepthConvention.NORMALIZED_INVERTED, "takes_ends needs_ends"),
        (DepthConvention.DISPARITY, "takes_ends is_disparity"),
        (DepthConvention.DISPARITY_INVERTED, "takes_ends is_disparity"),
        (DepthConvention.COC, "is_coc"),
    ],
)
def test_depth_convention_facts_tell_which_options_it_takes(convention, facts):
    convention_facts = convention.facts
    names = ("takes_ends", "needs_ends", "has_unit", "is_disparity", "is_coc")
    assert [name for name in names if getattr(convention_facts, name)] == facts.split()
    assert convention_facts.label and convention_facts.meaning


def test_plate_options_parse_convention_names_and_reject_others():
    assert DepthKind.RADIAL.label == "along the ray" and DepthKind.PLANAR.label == "along the axis"
    assert PlateOptions(depth_convention="coc").depth_convention is DepthConvention.COC
    assert PlateOptions(depth_kind="radial").depth_kind is DepthKind.RADIAL
    expect_input_error(lambda: PlateOptions(depth_convention="far"), "far")


def test_method_facts_and_ranges_of_defocus_settings():
    assert {m for m in Method if m.needs_scene} == {Method.ACCUMULATION, Method.RAYTRACED}
    assert {m for m in Method if m.facts.grows_with_blur} == {Method.GATHER, Method.SCATTER}
    assert Method.RAYTRACED.facts.views_are == "rays a pixel"
    assert Method.ACCUMULATION.facts.views_are == "views"
    assert set(barred_methods(has_many_views=False)) == {Method.ACCUMULATION, Method.RAYTRACED}
    assert barred_methods(has_many_views=True) == {}
    for wrong in ({"layers": 8}, {"layers": 0}, {"proxy": 1.01}, {"proxy": 0.06}, {"views": 0}):
        expect_input_error(lambda wrong=wrong: DefocusSettings(**wrong), "must be")
    DefocusSettings(layers=7, proxy=1 / 16, views=65536)


def test_opening_profile_keeps_light_at_extreme_rim_values():
    assert (opening.RIM_POWER, opening.RIM_MOST) == (2, 0.98)
    assert opening.profile(1.0, -1.0) == pytest.approx(0.02)
    assert opening.profile(0.0, 1.0) == pytest.approx(0.02)
    assert opening.profile(1.0, 1.0) == pytest.approx(1 + 0.98 * 2)


def test_third_stops_equal_engraved_numbers_of_iso_517():
    """The whole stops are those of ISO 517; the others are rounded as lens makers do."""
    ring = "0.7 0.8 0.9 1 1.1 1.2 1.4 1.6 1.8 2 2.2 2.5 2.8 3.2 3.5 4 4.5 5 5.6 6.3 7.1 8 9 10 11"
    assert [f"{stop:g}" for stop in THIRD_STOPS] == f"{ring} 13 14 16 18 20 22 25 29 32".split()
    for number, stop in enumerate(THIRD_STOPS):
        assert stop == pytest.approx(2 ** ((number - 3) / 6), rel=0.05)


NEAR_ROOM = DepthSpan(1.0, 5.0)


def test_doubts_name_lens_or_aperture_outside_real_hardware():
    def about(*lens):
        return [warning.about for warning in find_doubts(Lens(*lens), NEAR_ROOM)]

    assert about(50.0, 2.0, 2.0, 36.0) == []
    assert about(0.99, 2.0, 2.0, 3.0) == ["lens"] and about(1.0, 2.0, 2.0, 3.0) == []
    assert about(6001.0, 2.0, 20.0, 620.0) == ["lens"]
    assert about(50.0, 2.0, 2.0, 1.99) == ["lens"] and about(50.0, 2.0, 2.0, 2.0) == []
    assert about(500.0, 2.0, 2.0, 621.0) == ["lens"] and about(500.0, 22.0, 2.0, 620.0) == []
    assert about(50.0, 0.49, 2.0, 36.0) == ["aperture"] and about(50.0, 0.5, 2.0, 36.0) == []
    wide = 36.0 / 2 / math.tan(math.radians(80.0))  # 160 degrees
    assert about(wide * 1.01, 2.0, 2.0, 36.0) == [] and about(wide * 0.99, 2.0, 2.0, 36.0) == [
        *("lens",)
    ]
    narrow = 4.0 / 2 / math.tan(math.radians(0.15))  # 0.3 degrees
    assert about(narrow * 0.99, 64.0, 3.0, 4.0) == []
    assert about(narrow * 1.01, 64.0, 3.0, 4.0) == ["lens"]


def test_focus_unit_doubts_suggest_the_unit_of_a_focus_table():
    assert focus_unit_doubts([1.5, 3.0], NEAR_ROOM) == ()
    for first_distance, unit in ((2000.0, "mm"), (200.0, "cm"), (80.0, "in")):
        (warning,) = focus_unit_doubts([first_distance, first_distance * 1.1, math.inf], NEAR_ROOM)
        assert warning.about == "focus" and f"--table-unit focus={unit}" in warning.sentence
    assert focus_unit_doubts([math.inf], NEAR_ROOM) == () == focus_unit_doubts([], NEAR_ROOM)
    assert focus_unit_doubts([1e6], NEAR_ROOM) == ()  # no unit makes sense of it
    for near in (1 / 1.5, 5.0 * 1.5):  # a little outside may be wanted
        assert focus_unit_doubts([near], NEAR_ROOM) == ()
    (feet,) = focus_unit_doubts([7.6], NEAR_ROOM)
    assert "focus=ft" in feet.sentence


def test_span_doubts_start_at_nearest_depth_of_30_m():
    assert span_doubts(DepthSpan(29.9, 500.0)) == ()
    (warning,) = span_doubts(DepthSpan(30.0, 500.0))
    assert warning.about == "depth" and "cm" in warning.sentence
    assert plausibility._FAR_OFF == 1.5
