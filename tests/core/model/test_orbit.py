"""Test orbit, pan, dolly and framing of a camera, and the bounds and views of a scene."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.focus.coc import coc_line
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.camera_track import CameraTrack, Pose, PoseKey, pose_looking_at
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.view.orbit import dolly_camera, orbit_camera, pan_camera, pivot_of
from heatlens.media.scene.scene import SceneCamera
from heatlens.media.scene.scene_bounds import (
    _CLOSEST_PART,
    bounds_m,
    corners_m,
    first_framing,
    frame_points,
    object_depth_m,
    object_names,
    track_of,
)
from heatlens.media.scene.scene_view import pupil_of, view_of
from support.scenes import box, placement, scene_of

METRES = st.floats(-50, 50)
POSITIONS = st.tuples(METRES, METRES, METRES)
ANGLES = st.floats(-3, 3)
LENS = Lens(50.0, 2.0, 3.0, 36.0)


@st.composite
def upright_cameras(draw) -> tuple[Pose, tuple[float, float, float]]:
    """Draw a camera that looks at a pivot, not straight up or down, and the pivot."""
    eye, pivot = draw(POSITIONS), draw(POSITIONS)
    arm = np.subtract(eye, pivot)
    assume(np.hypot(arm[0], arm[2]) > 0.1 * np.linalg.norm(arm) and np.linalg.norm(arm) > 0.01)
    return pose_looking_at(eye, pivot), pivot


def arm_m(pose: Pose, pivot: tuple[float, float, float]) -> float:
    return float(np.linalg.norm(np.subtract(pose.position_m, pivot)))


@given(upright_cameras(), ANGLES, ANGLES)
def test_orbited_keeps_distance_to_pivot_and_centers_it(start, turn, tilt):
    pose, pivot = start
    orbited_pose = orbit_camera(pose, pivot, turn, tilt)
    radius = arm_m(pose, pivot)
    assert arm_m(orbited_pose, pivot) == pytest.approx(radius)
    pivot_in_camera = orbited_pose.world_to_camera @ (*pivot, 1.0)
    np.testing.assert_allclose(pivot_in_camera[:2], 0, atol=1e-6)
    assert pivot_in_camera[2] == pytest.approx(-radius)
    assert orbited_pose.turn[1, 1] > 0  # never upside down
    assert orbited_pose.turn[1, 0] == pytest.approx(0.0, abs=1e-9)


@given(upright_cameras(), st.floats(-1, 1))
def test_orbited_back_restores_pose(start, turn):
    pose, pivot = start
    turned = orbit_camera(pose, pivot, turn, 0.0)
    restored = orbit_camera(turned, pivot, -turn, 0.0)
    np.testing.assert_allclose(restored.camera_to_world, pose.camera_to_world, atol=1e-6)


def test_orbited_by_positive_angles_moves_right_and_up():
    pose = pose_looking_at((0, 0, 5), (0, 0, 0))
    assert orbit_camera(pose, (0.0, 0.0, 0.0), 0.1, 0.0).position_m[0] > 0
    assert orbit_camera(pose, (0.0, 0.0, 0.0), 0.0, 0.1).position_m[1] > 0


def test_orbited_camera_at_its_pivot_stays():
    assert orbit_camera(Pose(), (0.0, 0.0, 0.0), 1.0, 1.0) == Pose()


@given(upright_cameras(), METRES, METRES)
def test_pan_camera_moves_it_in_its_plane_without_turning(start, right, up):
    pose, _ = start
    panned_pose = pan_camera(pose, right, up)
    np.testing.assert_allclose(panned_pose.turn, pose.turn, atol=1e-9)
    by = pose.turn.T @ np.subtract(panned_pose.position_m, pose.position_m)
    np.testing.assert_allclose(by, (right, up, 0), atol=1e-9)


@given(upright_cameras(), st.floats(-5, 5))
def test_dollied_shortens_distance_and_never_passes_pivot(start, share):
    pose, pivot = start
    dollied_pose = dolly_camera(pose, pivot, share)
    np.testing.assert_allclose(dollied_pose.turn, pose.turn, atol=1e-9)
    remaining_share = max(1 - share, 0.05)
    assert arm_m(dollied_pose, pivot) == pytest.approx(
        remaining_share * arm_m(pose, pivot), rel=1e-6
    )


@given(upright_cameras())
def test_pivot_of_pose_lies_straight_ahead(start):
    pose, pivot = start
    np.testing.assert_allclose(pivot_of(pose, arm_m(pose, pivot)), pivot, atol=1e-6)


# Bounds and views of a scene

TWO = scene_of([box()], [(0, placement(-2.0)), (0, placement(3.0, 1.0, -4.0, 2.0))])


def test_bounds_enclose_corners_of_all_or_named_objects():
    np.testing.assert_allclose(bounds_m(TWO, 1), [(-2.5, -0.5, -5), (4, 2, 0.5)])
    np.testing.assert_allclose(bounds_m(TWO, 1, "thing 1"), [(2, 0, -5), (4, 2, -3)])
    assert np.isnan(bounds_m(TWO, 1, "nothing")).all()
    assert object_names(TWO) == ("thing 0", "thing 1")


def test_object_depth_is_depth_of_its_center_along_axis():
    pose = pose_looking_at((0, 1, 6), (0, 1, 0))
    assert object_depth_m(TWO, "thing 1", pose, 1) == pytest.approx(10.0)
    with pytest.raises(InputError, match="'no such'"):
        object_depth_m(TWO, "no such", pose, 1)
    with pytest.raises(InputError, match="behind the camera"):
        object_depth_m(TWO, "thing 1", pose_looking_at((0, 1, -6), (0, 1, -9)), 1)


def test_bounds_ignore_unused_vertices_and_follow_motion():
    mesh = box()
    stray = replace(mesh, positions_m=np.r_[mesh.positions_m, [[99, 99, 99]]].astype(np.float32))
    turned = np.eye(4)
    turned[:3, :3] = [[0, 0, 3], [0, 1, 0], [-1, 0, 0]]
    scene = scene_of([stray, box((1, 2, 3))], motion=lambda f: np.stack([placement(f), turned]))
    np.testing.assert_allclose(bounds_m(scene, 7, "thing 0"), [(6.5, -0.5, -0.5), (7.5, 0.5, 0.5)])
    np.testing.assert_allclose(bounds_m(scene, 0, "thing 1"), [(-9, -2, -1), (9, 2, 1)])
    assert corners_m(scene, 0).shape == (16, 3) and corners_m(scene, 0, "nothing").shape == (0, 3)


@given(
    upright_cameras(), st.floats(0.2, 5), st.lists(POSITIONS, min_size=2, max_size=9), st.booleans()
)
def test_frame_points_fits_all_points_to_the_margin(start, aspect, points, is_turned):
    turn = start[0].turn
    points = np.array(points)
    width = 900
    size = (width, max(1, round(width / aspect)))
    pose = frame_points(points, LENS, size[0] / size[1], turn if is_turned else None)
    sides = (points - (points.min(axis=0) + points.max(axis=0)) / 2) @ pose.turn
    assume(np.abs(sides[:, :2]).max() > 0.01 * np.ptp(points))  # not a line seen from its end
    if is_turned:
        np.testing.assert_allclose(pose.turn, turn, atol=1e-9)
    bounds = np.array([points.min(axis=0), points.max(axis=0)])
    view = view_of(pose, LENS, size, bounds)
    clip = np.c_[points, np.ones(len(points))] @ view.clip_from_world.T
    assert (clip[:, 3] > 0).all()
    # where a point near the axis keeps the camera away, the margin is wider
    assume(clip[:, 3].min() > 1.01 * _CLOSEST_PART * np.ptp(sides, axis=0).max())
    assert np.abs(clip[:, :2] / clip[:, 3:]).max() == pytest.approx(1 / 1.15, rel=1e-6)
    middle = pose.world_to_camera @ (*bounds.mean(axis=0), 1.0)
    np.testing.assert_allclose(middle[:2], 0, atol=1e-6)


@pytest.mark.parametrize("extent", [(0, 0, 0), (0, 0, 5), (1e-9, 0, 0), (1e6, 1e6, 0)])
def test_frame_points_stays_outside_of_point_or_line(extent):
    points = np.array([(0, 0, 0), extent], float)
    pose = frame_points(points, LENS, 1.5, np.eye(3))
    assert (points[:, 2] < pose.position_m[2]).all()


@given(upright_cameras(), POSITIONS, st.tuples(*[st.floats(-1, 1)] * 2), st.floats(0.5, 100))
def test_lens_offset_shifts_points_by_thin_lens_blur_radius(start, point, offset, focus_m):
    """The shift is F u (1/S - 1/z); at the edge of the pupil it is the blur radius of the lens."""
    pose, _ = start
    depth = -float((pose.world_to_camera @ (*point, 1.0))[2])
    assume(depth > 0.2)
    lens, size = replace(LENS, focus_distance_m=focus_m, squeeze=1.0), (640, 360)
    radius = pupil_of(lens).radius_m
    u, v = offset[0] * radius, offset[1] * radius
    box_m = np.array([point, point]) + np.array([[-1.0], [1.0]])
    pinhole = view_of(pose, lens, size, box_m)
    through = replace(pinhole, offset_m=(u, v))
    shift = [pixel(through, point)[i] - pixel(pinhole, point)[i] for i in (0, 1)]
    line = coc_line(lens, size[0])
    radius_px = (line.at_infinity_px + line.per_dioptre_px / depth) / 2
    np.testing.assert_allclose(np.abs(shift), np.abs(np.multiply(offset, radius_px)), 1e-6, 1e-6)


def pixel(view, point) -> tuple[float, float]:
    x, y, _, w = view.clip_from_world @ (*point, 1.0)
    return (x / w + 1) / 2 * view.size[0], (y / w + 1) / 2 * view.size[1]


def test_view_puts_pivot_in_center_with_rows_running_down():
    pose = pose_looking_at((0, 0, 5), (0, 0, 0))
    view = view_of(pose, LENS, (200, 100), np.array([[-1.0] * 3, [1.0] * 3]))
    assert pixel(view, (0, 0, 0)) == pytest.approx((100, 50))
    x, y = pixel(view, (0.5, 0.5, 0))
    assert x > 100 and y < 50
    np.testing.assert_allclose(view.eye_m, (0, 0, 5))


STATIC_TRACK = CameraTrack((PoseKey(1, pose_looking_at((0, 1, 9), (0, 0, 0))),))


def test_track_of_prefers_camera_of_shot_to_camera_of_scene():
    other_track = CameraTrack((PoseKey(1, pose_looking_at((9, 1, 0), (0, 0, 0))),))
    cameras = (
        SceneCamera(name="one", track=STATIC_TRACK, focal_length_mm=24.0, sensor_width_mm=24.0),
        SceneCamera(name="two", track=other_track, focal_length_mm=85.0, sensor_width_mm=36.0),
    )
    scene = scene_of([box()], cameras=cameras)
    assert track_of(scene, Framing(), LENS) == STATIC_TRACK
    assert track_of(scene, Framing(camera="two"), LENS) == other_track
    assert track_of(scene, Framing(camera="two", track=STATIC_TRACK), LENS) == STATIC_TRACK
    with pytest.raises(InputError, match="three"):
        track_of(scene, Framing(camera="three"), LENS)
    assert first_framing(scene) == Framing(camera="one")


def test_track_of_scene_without_camera_frames_whole_scene():
    small = scene_of([box()], [(0, placement(-1.0)), (0, placement(0.7, 0.5, -1.0, 0.5))])
    assert first_framing(small) == Framing()
    pose = track_of(small, Framing(), LENS).pose_at(1)
    view = view_of(pose, LENS, (640, 360), bounds_m(small, 1))
    corners = np.array([pixel(view, corner) for corner in corners_m(small, 1)]) / (640, 360)
    assert (corners > 0).all() and (corners < 1).all()
    assert np.abs(2 * corners - 1).max() > 0.85  # and is no smaller than it has to be
