"""A shot through a camera of its scene takes the lens values of the file, and keeps the others."""

from dataclasses import replace

import pytest

from heatlens.core.model.curves.curve import Key
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.camera_track import CameraTrack, PoseKey, pose_looking_at
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.media.scene.first_shot import through_camera
from heatlens.media.scene.scene import SceneCamera

TRACK = CameraTrack((PoseKey(1, pose_looking_at((9, 1, 0), (0, 0, 0))),))
LENS = Lens(35.0, 2.0, 5.0, 36.0)
FOCUS = LensParameter.FOCUS_DISTANCE


def shot_with_focus_keys():
    """Return a shot with two keys of the focus distance and its own camera track."""
    shot = Shot(LENS, framing=Framing(640, 360, track=TRACK))
    curve = shot.curves.of(FOCUS)
    for frame, value in ((1, 4.0), (9, 2.0)):
        curve = curve.with_key(Key(frame, value))
    return shot.with_curve(FOCUS, curve)


def test_through_camera_replaces_lens_and_keys_by_those_of_file():
    camera = SceneCamera(
        name="hero",
        track=TRACK,
        focal_length_mm=50.0,
        sensor_width_mm=24.9,
        f_stop=2.8,
        focus_distance_m=3.2,
    )
    shot = through_camera(shot_with_focus_keys(), camera)
    lens = shot.lens_at(5)
    assert (lens.focal_length_mm, lens.sensor_width_mm) == (50.0, 24.9)
    assert (lens.f_stop, lens.focus_distance_m) == (2.8, 3.2)
    assert shot.framing == Framing(width_px=640, height_px=360, camera="hero")


def test_through_camera_keeps_values_missing_in_file():
    before = shot_with_focus_keys()
    shot = through_camera(before, SceneCamera("hero", TRACK, 50.0, 36.0))
    assert shot.curves.of(FOCUS) == before.curves.of(FOCUS)
    assert shot.lens == replace(LENS, focal_length_mm=50.0)


def test_through_camera_keys_zoom_of_file():
    camera = SceneCamera(
        name="hero",
        track=TRACK,
        focal_length_mm=50.0,
        sensor_width_mm=36.0,
        lens_frames=(1, 2, 3),
        lens_tracks={"focal_length_mm": (50, 60, 70)},
    )
    shot = through_camera(shot_with_focus_keys(), camera)
    assert [shot.lens_at(f).focal_length_mm for f in (1, 2, 3)] == pytest.approx([50, 60, 70])


def test_through_camera_keeps_field_of_view_if_sensor_width_is_assumed():
    camera = SceneCamera("hero", TRACK, 36.0, 36.0, is_width_assumed=True)
    shot = through_camera(
        replace(shot_with_focus_keys(), lens=replace(LENS, sensor_width_mm=24.0)), camera
    )
    assert (shot.lens.focal_length_mm, shot.lens.sensor_width_mm) == (24.0, 24.0)
