"""Test camera poses and tracks: orientation, keys, interpolation, and saving in a shot file."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.marks import DistanceMark, ObjectMark, PointMark
from heatlens.core.model.shot.camera_track import (
    CameraTrack,
    Pose,
    PoseKey,
    pose_looking_at,
    pose_of,
)
from heatlens.core.model.shot.framing import SIZE_MOST_PX, Framing
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.shot_file import read_shot, write_shot

METRES = st.floats(-100, 100)
PLACES = st.tuples(METRES, METRES, METRES)
PARTS = st.floats(-1, 1)
TURNS = st.tuples(PARTS, PARTS, PARTS, PARTS).filter(lambda q: np.linalg.norm(q) > 0.1)
POSES = st.builds(Pose, PLACES, TURNS)


@st.composite
def tracks(draw, most: int = 5) -> CameraTrack:
    frames = draw(st.lists(st.integers(-50, 300), min_size=1, max_size=most, unique=True))
    return CameraTrack(tuple(PoseKey(float(frame), draw(POSES)) for frame in sorted(frames)))


@given(POSES)
def test_pose_matrix_is_rigid_and_inverse_of_world_to_camera(pose):
    np.testing.assert_allclose(pose.turn @ pose.turn.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(pose.turn) == pytest.approx(1.0)
    product = pose.world_to_camera @ pose.camera_to_world
    np.testing.assert_allclose(product, np.eye(4), atol=1e-12)


@given(POSES, st.floats(0.01, 100))
def test_pose_of_scaled_matrix_returns_original_pose(pose, scale):
    matrix = pose.camera_to_world
    matrix[:3, :3] *= scale
    np.testing.assert_allclose(pose_of(matrix).camera_to_world, pose.camera_to_world, atol=1e-9)


@given(POSES)
def test_pose_rebuilt_from_its_values_is_bit_identical(pose):
    assert Pose(pose.position_m, pose.orientation) == pose


@given(PLACES, PLACES)
def test_pose_looking_at_centers_target_and_keeps_picture_upright(eye, target):
    distance = float(np.linalg.norm(np.subtract(target, eye)))
    assume(distance > 1e-3)
    pose = pose_looking_at(eye, target)
    in_camera = pose.world_to_camera @ (*target, 1.0)
    np.testing.assert_allclose(in_camera[:3], (0, 0, -distance), atol=1e-9)
    assert pose.turn[1, 0] == pytest.approx(0.0, abs=1e-9)  # the right is level
    assert pose.turn[1, 1] >= -1e-9  # and the top above


@pytest.mark.parametrize("up", [1.0, -1.0])
def test_pose_looking_at_works_straight_up_and_down(up):
    pose = pose_looking_at((1.0, 2.0, 3.0), (1.0, 2.0 + up, 3.0))
    np.testing.assert_allclose(-pose.turn[:, 2], (0, up, 0), atol=1e-12)
    np.testing.assert_allclose(pose.turn @ pose.turn.T, np.eye(3), atol=1e-12)


@pytest.mark.parametrize(
    "make_invalid",
    [
        lambda: pose_looking_at((1.0, 1.0, 1.0), (1.0, 1.0, 1.0)),
        lambda: Pose(orientation=(0.0, 0.0, 0.0, 0.0)),
        lambda: Pose((float("nan"), 0.0, 0.0)),
        lambda: Pose((float("inf"), 0.0, 0.0)),
        lambda: Pose(orientation=(float("nan"), 0.0, 0.0, 1.0)),
        lambda: CameraTrack(()),
        lambda: CameraTrack((PoseKey(2, Pose()), PoseKey(1, Pose()))),
        lambda: CameraTrack((PoseKey(2, Pose()), PoseKey(2, Pose()))),
        lambda: Framing(0, 720),
        lambda: Framing(1280, SIZE_MOST_PX + 1),
        lambda: ObjectMark("A", ""),
        lambda: ObjectMark("", "thing"),
    ],
)
def test_invalid_pose_track_framing_or_mark_raises_input_error(make_invalid):
    with pytest.raises(InputError, match=r"\.$"):
        make_invalid()


@given(tracks())
def test_camera_track_meets_its_keys_and_is_constant_outside(track):
    first, last = track.keys[0], track.keys[-1]
    assert track.pose_at(first.frame - 10) == first.pose
    assert track.pose_at(last.frame + 10) == last.pose
    for key in track.keys:
        at = track.pose_at(key.frame).camera_to_world
        np.testing.assert_allclose(at, key.pose.camera_to_world, atol=1e-9)


@given(tracks(), st.floats(-50, 300))
def test_camera_track_between_keys_is_continuous(track, frame):
    """In a thousandth of a frame the camera moves less than the steepest cubic of such keys."""
    a, b = track.pose_at(frame), track.pose_at(frame + 1e-3)
    assert np.linalg.norm(np.subtract(a.position_m, b.position_m)) < 2.0


def test_camera_track_halfway_between_two_keys_is_mean_pose():
    a, b = pose_looking_at((0, 0, 5), (0, 0, 0)), pose_looking_at((5, 0, 0), (0, 0, 0))
    middle = CameraTrack((PoseKey(0, a), PoseKey(10, b))).pose_at(5)
    np.testing.assert_allclose(middle.position_m, (2.5, 0, 2.5))
    np.testing.assert_allclose(middle.turn[:, 2], (0.5**0.5, 0, 0.5**0.5), atol=1e-12)


@given(POSES, POSES)
def test_camera_track_treats_negated_quaternion_as_same_pose(a, b):
    mirrored = Pose(b.position_m, tuple(-value for value in b.orientation))
    first_track, mirrored_track = (
        CameraTrack((PoseKey(0, a), PoseKey(10, pose))) for pose in (b, mirrored)
    )
    assume(abs(np.dot(a.orientation, b.orientation)) > 1e-6)  # else both ways round are as near
    np.testing.assert_allclose(
        first_track.pose_at(4).turn, mirrored_track.pose_at(4).turn, atol=1e-9
    )


@given(tracks(), st.integers(-60, 310), POSES)
def test_with_key_sets_one_key_and_keeps_others(track, frame, pose):
    keyed = track.with_key(frame, pose)
    assert keyed.pose_at(frame) == pose or frame in [key.frame for key in keyed.keys[1:-1]]
    np.testing.assert_allclose(keyed.pose_at(frame).position_m, pose.position_m, atol=1e-9)
    others = [key for key in track.keys if key.frame != frame]
    assert [key for key in keyed.keys if key.frame != frame] == others
    without = keyed.without_key(frame)
    assert list(without.keys) == (others or list(keyed.keys))


@given(tracks(), st.data(), st.integers(-400, 400))
def test_moved_pose_keys_replace_keys_at_target_frames(track, data, by):
    chosen = data.draw(st.sets(st.sampled_from([key.frame for key in track.keys])))
    poses = {key.frame: key.pose for key in track.keys}
    unmoved_poses = {frame: pose for frame, pose in poses.items() if frame not in chosen}
    expected = unmoved_poses | {frame + by: poses[frame] for frame in chosen}
    moved_poses = {key.frame: key.pose for key in track.move_keys(chosen, by).keys}
    assert moved_poses == expected and list(moved_poses) == sorted(moved_poses)


@given(tracks(), st.integers(-60, 310), st.integers(-100, 100))
def test_rippled_track_shifts_later_keys_and_drops_cut_ones(track, start, by):
    poses = {key.frame: key.pose for key in track.keys}
    early = {frame: pose for frame, pose in poses.items() if frame < start + min(by, 0)}
    moved = {frame + by: pose for frame, pose in poses.items() if frame >= start}
    assume(early or moved)
    assert {key.frame: key.pose for key in track.ripple_keys(start, by).keys} == early | moved


@given(tracks(), st.integers(-60, 310), POSES)
def test_framing_at_pose_adds_key_only_if_camera_moves(track, frame, pose):
    framing = Framing(camera="main", track=track).with_pose(pose, frame)
    assert framing.camera == "main" and framing.track is not None
    expected = track.with_key(frame, pose).keys if track.is_moving else (PoseKey(frame, pose),)
    assert framing.track.keys == expected


FRAMINGS = st.builds(
    Framing,
    st.integers(1, SIZE_MOST_PX),
    st.integers(1, SIZE_MOST_PX),
    st.none() | st.text(min_size=1, max_size=8),
    st.none() | tracks(),
)


@given(framing=FRAMINGS)
def test_framing_survives_shot_file(tmp_path_factory, framing):
    path = tmp_path_factory.getbasetemp() / "framing.heatlens.json"
    shot = Shot(Lens(35.0, 2.0, 3.0, 36.0), source="demo", framing=framing)
    write_shot(path, shot)
    assert read_shot(path) == shot


def test_marks_of_all_kinds_survive_shot_file(tmp_path):
    marks = (DistanceMark("A", 2.0), PointMark("B", 3.0, 4.5, 5), ObjectMark("C", "the cup"))
    path = tmp_path / "marks.heatlens.json"
    shot = Shot(Lens(35.0, 2.0, 3.0, 36.0), marks=marks)
    write_shot(path, shot)
    assert read_shot(path) == shot


def test_read_shot_keeps_demo_source_and_resolves_moved_scene(tmp_path):
    shot = Shot(Lens(35.0, 2.0, 3.0, 36.0), source="demo", framing=Framing())
    path = tmp_path / "a.heatlens.json"
    write_shot(path, shot)
    assert read_shot(path).source == "demo"
    write_shot(path, replace(shot, source=str(tmp_path / "scene.glb")))
    moved = tmp_path / "elsewhere" / path.name
    moved.parent.mkdir()
    path.rename(moved)
    assert Path(read_shot(moved).source) == moved.parent / "scene.glb"


@pytest.mark.parametrize(
    ("framing", "message"),
    [
        ('{"width_px": 0}', "framing: A picture has"),
        ('{"track": {"keys": []}}', r"framing.track: A camera track needs"),
        ('{"track": {"keys": [{"frame": 1}]}}', r"keys\[0\]: the entry 'pose' is missing"),
        (
            '{"track": {"keys": [{"frame": 1, "pose": {"position_m": [1, 2]}}]}}',
            r"keys\[0\].pose.position_m: there should be 3 values, not 2",
        ),
        (
            '{"track": {"keys": [{"frame": 1, "pose": {"position_m": [1, 2, "x"]}}]}}',
            r"position_m\[2\]: \"x\" should be a number",
        ),
        (
            '{"track": {"keys": [{"frame": 1, "pose": {"position_m": ["inf", 0, 0]}}]}}',
            r"keys\[0\].pose: A camera stands at a finite place",
        ),
        ('{"track": 3}', "framing.track: 3 should be an object"),
        ('{"hight_px": 3}', "did you mean 'height_px'"),
    ],
)
def test_read_shot_names_place_of_damaged_framing_entry(tmp_path, framing, message):
    path = tmp_path / "bad.heatlens.json"
    lens = '{"focal_length_mm": 35, "f_stop": 2, "focus_distance_m": 3, "sensor_width_mm": 36}'
    path.write_text(f'{{"heatlens_shot": 1, "lens": {lens}, "framing": {framing}}}')
    with pytest.raises(InputError, match=message) as error:
        read_shot(path)
    assert str(path) in str(error.value)


@given(tracks())
def test_camera_key_frames_are_empty_for_static_camera(track):
    shot = Shot(Lens(50.0, 2.0, 2.0, 36.0), framing=Framing(track=track))
    frames = tuple(key.frame for key in track.keys)
    assert shot.camera_key_frames == (frames if len(frames) > 1 else ())
    assert replace(shot, framing=Framing()).camera_key_frames == ()
    assert replace(shot, framing=None).camera_key_frames == ()
