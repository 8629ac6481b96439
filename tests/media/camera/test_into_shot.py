"""Test that a shot made from a camera has its lens at every frame, with as few keys as needed."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError, LensError
from heatlens.core.model.curves.curve import Curve, Key
from heatlens.core.model.curves.interpolation import Interpolation, Scale
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.media.camera.into_shot import linear_keys, with_camera
from heatlens.render.source.named import camera_of_shot
from support.cameras import FRAMES, SHOTS, moving_camera

OTHER = Shot(Lens(24.0, 8.0, 3.0, 23.5, close_focus_m=0.45, t_stop=9.0))
VALUES = st.floats(0.5, 1e3)


def lens_values(lens: Lens) -> list[float]:
    return [*(getattr(lens, parameter) for parameter in LensParameter), lens.sensor_width_mm]


@given(SHOTS, st.sampled_from([Scale.RECIPROCAL, Scale.LINEAR]))
def test_with_camera_gives_shot_the_lens_of_camera_at_every_frame(shot, scale):
    camera = camera_of_shot(shot, "a")
    if np.inf in camera.focus_distance_m:
        scale = Scale.RECIPROCAL
    new_shot = with_camera(OTHER.with_focus_scale(scale), camera)
    for frame in FRAMES:
        expected = lens_values(shot.lens_at(frame))
        assert lens_values(new_shot.lens_at(frame)) == pytest.approx(expected, rel=4e-7)


@given(SHOTS)
def test_with_camera_sets_keys_only_for_changing_values(shot):
    new_shot = with_camera(OTHER, camera_of_shot(shot, "a"))
    for parameter in LensParameter:
        values = {getattr(shot.lens_at(frame), parameter) for frame in FRAMES}
        assert bool(new_shot.curves.of(parameter).keys) == (len(values) > 1)


@pytest.mark.parametrize("scale", list(Scale))
def test_linear_keys_of_straight_line_are_its_two_ends(scale):
    line = Curve((Key(1, 2.0, Interpolation.LINEAR), Key(100, 9.0)), scale)
    frames = tuple(range(1, 101))
    keys = linear_keys(frames, tuple(line.value_at(frame) for frame in frames), scale)
    assert [(key.frame, key.value) for key in keys] == [(1, 2.0), (100, 9.0)]


def test_linear_keys_keep_corners_of_track():
    track = (1.0, 1.0, 1.0, 3.0, 5.0, 5.0, 5.0, 2.0)
    keys = linear_keys(tuple(range(8)), track, Scale.LINEAR)
    assert [key.frame for key in keys] == [0, 2, 4, 6, 7]


def test_linear_keys_of_slow_curve_are_several():
    """Each step is straight within the tolerance, but the whole track is not."""
    frames = tuple(range(200))
    track = tuple(1 + 1e-9 * frame**2 for frame in frames)
    curve = Curve(linear_keys(frames, track, Scale.LINEAR))
    assert [curve.value_at(frame) for frame in frames] == pytest.approx(track, rel=2.1e-7)
    assert 3 < len(curve.keys) < 100


@given(
    st.lists(VALUES | st.just(np.inf), min_size=1, max_size=30),
    st.lists(st.integers(1, 5), min_size=30, max_size=30),
)
def test_linear_keys_meet_every_frame_on_every_scale(track, steps):
    frames = tuple(int(frame) for frame in np.cumsum(steps[: len(track)]))
    for scale in Scale if np.inf not in track else [Scale.RECIPROCAL]:
        keys = linear_keys(frames, tuple(track), scale)
        curve = Curve(keys, scale) if keys else Curve((Key(0, track[0]),), scale)
        values = [curve.value_at(frame) for frame in frames]
        assert values == pytest.approx(track, rel=2.1e-7)


def test_with_camera_keeps_requested_and_unknown_parameters():
    camera = moving_camera(f_stop=None)
    new_shot = with_camera(OTHER.with_key(5, LensParameter.SQUEEZE, 1.2), camera, ["squeeze"])
    assert new_shot.lens_at(1001).f_stop == 8.0
    assert new_shot.curves.squeeze.keys == (Key(5, 1.2),)
    assert (new_shot.lens.close_focus_m, new_shot.lens.t_stop) == (0.45, 9.0)
    assert new_shot.lens_at(1008).focus_distance_m == np.inf
    assert new_shot.lens.sensor_width_mm == 36.0


def test_with_camera_rejects_changing_sensor_width_unless_kept():
    widths = (36.0,) * 7 + (24.0,)
    camera = moving_camera(sensor_width_mm=widths)
    with pytest.raises(InputError, match="24 to 36 mm wide, but a shot has one width"):
        with_camera(OTHER, camera)
    assert with_camera(OTHER, camera, ["sensor_width_mm"]).lens.sensor_width_mm == 23.5


def test_with_camera_error_names_frame_of_impossible_lens():
    focus = (2.0,) * 6 + (0.03, 2.0)
    with pytest.raises(LensError, match="Frame 1007: The focus distance must be beyond"):
        with_camera(OTHER, moving_camera(focus_distance_m=focus))


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"frames": ()}, "needs at least one frame"),
        ({"frames": (*range(1001, 1008), 1007)}, "two entries for frame 1007"),
        ({"frames": tuple(range(1001, 1008))}, "8 values for 7 frames"),
        ({"f_stop": (0.0,) * 8}, "Frame 1001: the f-stop of a camera must be .*, got 0"),
        (
            {"f_stop": (2.0,) * 7 + (np.inf,)},
            "Frame 1008: the f-stop of a camera must be .*, got inf",
        ),
        ({"focus_distance_m": (np.nan,) * 8}, "the focus distance of a camera must be .*, got nan"),
        ({"sensor_height_mm": (-1.0,) * 8}, "the sensor height of a camera must be .*, got -1"),
        ({"frames_per_second": 0.0}, "Frames per second"),
        ({"up_axis": "x"}, "The axis that points up is y or z, not 'x'"),
    ],
)
def test_camera_samples_reject_inconsistent_frames_or_axis(change, sentence):
    with pytest.raises(InputError, match=sentence):
        moving_camera(**change)


def test_camera_samples_identifier_is_valid_in_any_program():
    names = {"hero cam": "hero_cam", "1a": "_1a", "": "_", "shot-02.v3": "shot_02_v3", "ü": "_"}
    for name, identifier in names.items():
        assert replace(moving_camera(), name=name).identifier == identifier
