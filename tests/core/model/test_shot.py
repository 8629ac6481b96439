"""Test a shot over time: the lens at every frame, marks, and focus pulls."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError, LensError
from heatlens.core.model.curves.curve import Curve
from heatlens.core.model.curves.frames import FrameRange, parse_frame_range
from heatlens.core.model.curves.interpolation import Scale
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.mark import free_letter
from heatlens.core.model.marks.marks import DistanceMark, MatteMark, PointMark, distance_at_m
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.pull import frames_too_close, pull
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings
from heatlens.core.model.shot.shot import LensCurves, Shot

FIFTY = Lens(50.0, 2.0, 2.24, 36.0)
FOCUS, F_STOP, FOCAL_LENGTH, SQUEEZE, TILT, SPLIT = LensParameter
DISTANCES = st.floats(0.1, 500.0)
VALUES = {FOCUS: 3.5, F_STOP: 5.6, FOCAL_LENGTH: 85.0, SQUEEZE: 1.5, TILT: 4.0, SPLIT: 0.5}


def focus_at(shot: Shot, frame: float) -> float:
    return shot.lens_at(frame).focus_distance_m


def test_lens_at_of_shot_without_keys_is_its_lens():
    shot = Shot(FIFTY)
    assert shot.lens_at(-5) is shot.lens_at(1001.5) is FIFTY
    other_lens = replace(FIFTY, f_stop=8.0)
    assert replace(shot, lens=other_lens).lens_at(1001) is other_lens


def test_shot_has_the_defocus_settings_it_is_made_with():
    assert Shot(FIFTY, DefocusSettings(Bokeh.HEAT)).defocus.bokeh is Bokeh.HEAT


def test_shots_compare_and_hash_by_value():
    mark = DistanceMark("A", 2.0)
    keyed = [Shot(FIFTY, marks=(mark,)).with_key(1001, FOCUS, 2.0) for _ in range(2)]
    assert keyed[0] == keyed[1] and len(set(keyed)) == 1
    assert keyed[0] != keyed[0].with_key(1001, FOCUS, 2.1)


@pytest.mark.parametrize("parameter", LensParameter)
def test_with_lens_value_without_keys_sets_value_for_all_frames(parameter):
    shot = Shot(FIFTY).with_lens_value(1010, parameter, VALUES[parameter])
    assert shot.key_frames == ()
    assert getattr(shot.lens_at(7), parameter) == VALUES[parameter]


@pytest.mark.parametrize("parameter", LensParameter)
def test_with_lens_value_adds_key_if_parameter_has_keys(parameter):
    before = getattr(FIFTY, parameter)
    shot = Shot(FIFTY).with_key(1001, parameter).with_lens_value(1010, parameter, VALUES[parameter])
    assert shot.key_frames == (1001, 1010)
    assert getattr(shot.lens_at(1001), parameter) == before
    assert getattr(shot.lens_at(1010), parameter) == VALUES[parameter]
    low, high = sorted((before, VALUES[parameter]))
    assert low < getattr(shot.lens_at(1005), parameter) < high


def test_with_lens_value_without_auto_key_changes_only_existing_keys():
    shot = Shot(FIFTY).with_key(1001, FOCUS)
    with pytest.raises(InputError, match="at frame 1010"):
        shot.with_lens_value(1010, FOCUS, 3.0, auto_key=False)
    changed = shot.with_lens_value(1001, FOCUS, 3.0, auto_key=False)
    assert focus_at(changed, 1001) == 3.0 and changed.key_frames == (1001,)


def test_with_lens_value_rejects_impossible_lens():
    for shot in (Shot(FIFTY), Shot(FIFTY).with_key(1001, FOCUS)):
        with pytest.raises(LensError, match="beyond the focal length"):
            shot.with_lens_value(1010, FOCUS, 0.03)
    zoomed = Shot(FIFTY).with_key(1001, FOCAL_LENGTH, 200.0)
    with pytest.raises(LensError, match="focal length of 200 mm"):
        zoomed.with_lens_value(1001, FOCUS, 0.1)


def test_lens_at_names_frame_of_impossible_lens():
    shot = Shot(FIFTY).with_key(0, FOCUS, 0.06).with_key(10, FOCAL_LENGTH, 55.0)
    crossing = shot.with_curve(FOCAL_LENGTH, shot.curves.focal_length_mm.with_value(20, 200.0))
    with pytest.raises(LensError, match=r"^Frame 20: .*focal length of 200 mm"):
        crossing.lens_at(20)


def test_f_stop_interpolates_in_stops_and_focus_in_dioptres():
    shot = Shot(FIFTY).with_key(0, F_STOP, 2.0).with_key(8, F_STOP, 8.0)
    assert shot.lens_at(4).f_stop == pytest.approx(4.0, rel=1e-12)
    shot = Shot(FIFTY).with_key(0, FOCUS, 2.0).with_key(8, FOCUS, math.inf)
    assert focus_at(shot, 4) == pytest.approx(4.0, rel=1e-12)


def test_linear_focus_scale_interpolates_meters_and_rejects_infinity():
    shot = Shot(FIFTY).with_key(0, FOCUS, 2.0).with_key(8, FOCUS, 8.0)
    assert focus_at(shot.with_focus_scale(Scale.LINEAR), 4) == pytest.approx(5.0, rel=1e-12)
    with pytest.raises(InputError, match="use the scale of dioptres for infinity"):
        shot.with_key(8, FOCUS, math.inf).with_focus_scale(Scale.LINEAR)


def test_removing_last_key_keeps_its_value_as_lens_value():
    shot = Shot(FIFTY).with_key(1001, FOCUS, 5.0).with_key(1010, FOCUS, 7.0)
    assert shot.without_key(1010, FOCUS).key_frames == (1001,)
    bare = shot.without_key(1010, FOCUS).without_key(1001, FOCUS)
    assert bare == Shot(replace(FIFTY, focus_distance_m=5.0))
    assert shot.without_key(1005, FOCUS) == shot
    assert shot.without_keys(1010, FOCUS) == Shot(replace(FIFTY, focus_distance_m=7.0))


def test_lens_curves_reject_other_scale_except_for_focus():
    assert LensCurves(focus_distance_m=Curve(scale=Scale.LINEAR)).focus_distance_m.keys == ()
    with pytest.raises(InputError, match="Keys of f_stop"):
        LensCurves(f_stop=Curve())


def test_shot_span_and_played_range_of_plate_keys_and_in_out():
    keyed = Shot(FIFTY).with_key(1001.5, FOCUS).with_key(1024, F_STOP)
    assert Shot(FIFTY).span is None and Shot(FIFTY).played_frames is None
    assert keyed.span == FrameRange(1001, 1024)
    plate = replace(keyed, frames=FrameRange(990, 1100))
    assert plate.span == plate.played_frames == FrameRange(990, 1100)
    assert replace(plate, in_out=FrameRange(1000, 1200)).played_frames == FrameRange(1000, 1100)
    assert replace(plate, in_out=FrameRange(1, 2)).played_frames == FrameRange(990, 1100)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"frames_per_second": 0.0}, "Frames per second"),
        ({"frames_per_second": math.nan}, "Frames per second"),
        ({"source": ""}, "which cannot be a file"),
        ({"source": "a\0b"}, "which cannot be a file"),
        ({"marks": (DistanceMark("A", 1.0), DistanceMark("A", 2.0))}, "Two marks are called A"),
    ],
)
def test_shot_rejects_impossible_values(change, words):
    with pytest.raises(InputError, match=words):
        replace(Shot(FIFTY), **change)


def test_parse_frame_range_reads_first_and_last_frame():
    frames = parse_frame_range(" 1001-1024 ")
    assert (frames.first, frames.last, frames.count) == (1001, 1024, 24)
    assert list(parse_frame_range("-2-1")) == [-2, -1, 0, 1] and 0 in parse_frame_range("-2-1")
    assert str(parse_frame_range("7")) == "7-7"


@pytest.mark.parametrize("text", ["", "a-b", "1024-1001", "1-", "1-2-3", "1-99999999", "1.5-2"])
def test_parse_frame_range_rejects_invalid_text(text):
    with pytest.raises(InputError):
        parse_frame_range(text)


@given(DISTANCES, DISTANCES, st.integers(-100, 2000), st.integers(1, 200), st.floats(0, 100))
def test_pull_goes_from_near_to_far_without_overshoot(near, far, start, frames, ease):
    shot = pull(Shot(FIFTY), near, far, start, frames, ease)
    assert focus_at(shot, start) == focus_at(shot, start - 9) == near
    assert focus_at(shot, start + frames) == focus_at(shot, start + frames + 9) == far
    low, high = sorted((near, far))
    path = [focus_at(shot, start + frames * part / 16) for part in range(17)]
    assert all(low * (1 - 1e-9) <= focus <= high * (1 + 1e-9) for focus in path)


@given(DISTANCES, DISTANCES, st.floats(-100, 300))
def test_focus_distance_at_is_that_of_the_lens(near, far, frame):
    pulled = pull(Shot(FIFTY), near, far, 0, 100)
    assert pulled.focus_distance_at(frame) == focus_at(pulled, frame)
    assert Shot(FIFTY).focus_distance_at(frame) == FIFTY.focus_distance_m


def test_pull_with_default_ease_is_smoothstep_in_dioptres():
    shot = pull(Shot(FIFTY), 1.0, math.inf, 1001, 24)
    for frame in range(1001, 1025):
        u = (frame - 1001) / 24
        assert 1 / focus_at(shot, frame) == pytest.approx(1 - u * u * (3 - 2 * u), rel=1e-9)


def test_pull_replaces_only_keys_inside_its_range():
    keyed = Shot(FIFTY)
    for frame in (1000, 1005, 1010, 1030):
        keyed = keyed.with_key(frame, FOCUS, 3.0)
    shot = pull(keyed, 1.0, 2.0, 1001, 20)
    assert [(k.frame, k.value) for k in shot.curves.focus_distance_m.keys] == [
        (1000, 3.0),
        (1001, 1.0),
        (1021, 2.0),
        (1030, 3.0),
    ]


def test_adjacent_pulls_keep_their_own_ease_at_shared_key():
    shot = pull(pull(Shot(FIFTY), 1.0, 2.0, 0, 10, 80.0), 2.0, 4.0, 10, 10, 20.0)
    middle = shot.curves.focus_distance_m.key_at(10)
    assert middle is not None
    assert middle.ease_in.influence_percent == 80.0 and middle.ease_out.influence_percent == 20.0


@pytest.mark.parametrize("frames", [0, -5, math.nan])
def test_pull_rejects_duration_of_zero_or_less(frames):
    with pytest.raises(InputError, match="must last more than"):
        pull(Shot(FIFTY), 1.0, 2.0, 1001, frames)


def test_pull_rejects_target_within_focal_length():
    with pytest.raises(LensError, match=r"Frame 1011: .*beyond the focal length"):
        pull(Shot(FIFTY), 1.0, 0.01, 1001, 10)


def test_frames_too_close_lists_frames_below_close_focus():
    lens = replace(FIFTY, close_focus_m=0.5)
    shot = Shot(lens, frames=FrameRange(0, 20))
    linear = pull(shot, 1.0, 0.25, 0, 12, 0.0)  # 1 to 4 dioptres, 0.25 a frame: 2 at frame 4
    assert frames_too_close(linear) == tuple(range(5, 21))
    assert frames_too_close(pull(shot, 1.0, 0.5, 0, 12)) == ()
    assert frames_too_close(replace(linear, lens=FIFTY)) == ()  # not known: nothing to say
    assert frames_too_close(Shot(lens)) == ()


@pytest.mark.parametrize("close_focus_m", [0.0, -1.0, math.nan, math.inf])
def test_lens_rejects_impossible_close_focus(close_focus_m):
    with pytest.raises(LensError, match="close focus"):
        replace(FIFTY, close_focus_m=close_focus_m)


def test_free_letter_names_marks_a_to_z_and_fills_gaps():
    marks: list[DistanceMark] = []
    for _ in range(30):
        marks.append(DistanceMark(free_letter(mark.name for mark in marks), 1.0))
    names = [mark.name for mark in marks]
    assert names[:3] == ["A", "B", "C"] and names[25:28] == ["Z", "A1", "B1"]
    assert free_letter(mark.name for mark in marks[:1] + marks[2:]) == "B"


def test_distance_at_of_distance_mark_reads_no_depth():
    assert distance_at_m(DistanceMark("A", math.inf), 1001, lambda *_: 1 / 0) == math.inf


@given(st.integers(1, 9), st.integers(1, 30))
def test_distance_at_of_point_mark_follows_steady_approach_without_lag(smooth_frames, frame):
    requests = []

    def depth_at(depth_frame: int, x: float, y: float) -> float:
        requests.append((depth_frame, x, y))
        return 1 / (0.1 + 0.02 * depth_frame)

    mark = PointMark("A", 12.5, 7.5, smooth_frames)
    distance_m = distance_at_m(mark, frame, depth_at, FrameRange(1, 30))
    assert distance_m == pytest.approx(depth_at(frame, 0, 0), rel=1e-12)
    assert all(1 <= at <= 30 for at, _, _ in requests)
    assert {request[1:] for request in requests[:-1]} == {(12.5, 7.5)}


def test_distance_at_of_point_mark_averages_noise_in_dioptres():
    def depth_at(frame: int, x: float, y: float) -> float:
        return 2.0 if frame % 2 else math.inf

    distance_m = distance_at_m(PointMark("A", 0, 0, 5), 10, depth_at)
    assert distance_m == pytest.approx(5.0, rel=1e-12)  # 2 of 5 frames at 0.5 dioptres
    assert distance_at_m(PointMark("A", 0, 0), 10, depth_at) == math.inf


@pytest.mark.parametrize(
    "make",
    [
        lambda: DistanceMark("", 1.0),
        lambda: DistanceMark(" A", 1.0),
        lambda: DistanceMark("A\n", 1.0),
        lambda: DistanceMark("A", 0.0),
        lambda: DistanceMark("A", math.nan),
        lambda: PointMark("A", math.nan, 0.0),
        lambda: PointMark("A", 0.0, math.inf),
        lambda: PointMark("A", 0.0, 0.0, 0),
        lambda: MatteMark("A", "hero"),
        lambda: MatteMark("A", ":hero"),
        lambda: MatteMark("A", "cryptomatte:"),
    ],
)
def test_marks_reject_impossible_values(make):
    with pytest.raises(InputError, match="ark"):
        make()


def test_each_keyed_parameter_has_a_control_of_its_own():
    controls = [parameter.control for parameter in LensParameter]
    assert controls[:3] == ["distance", "f-stop", "focal length"]
    assert all(controls) and len(set(controls)) == len(controls)
