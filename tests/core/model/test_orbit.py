"""The hand on a camera, by the laws of each motion; and what of a scene a camera sees."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.focus.coc import coc_line
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import CameraTrack, Framing, Pose, PoseKey, looking_at
from heatlens.core.model.view.orbit import dollied, orbited, panned, pivot_of
from heatlens.media.scene.scene import SceneCamera
from heatlens.media.scene.scene_bounds import (
    bounds_m,
    corners_m,
    framed,
    object_depth_m,
    object_names,
    started_framing,
    track_of,
)
from heatlens.media.scene.scene_view import pupil_of, view_of
from support.scenes import box, moved, scene_of

METRES = st.floats(-50, 50)
PLACES = st.tuples(METRES, METRES, METRES)
ANGLES = st.floats(-3, 3)
LENS = Lens(50.0, 2.0, 3.0, 36.0)


@st.composite
def upright(draw) -> tuple[Pose, tuple[float, float, float]]:
    """Return a camera that looks at a pivot, not straight up or down."""
    eye, pivot = draw(PLACES), draw(PLACES)
    arm = np.subtract(eye, pivot)
    assume(np.hypot(arm[0], arm[2]) > 0.1 * np.linalg.norm(arm) and np.linalg.norm(arm) > 0.01)
    return looking_at(eye, pivot), pivot


def arm_m(pose: Pose, pivot: tuple[float, float, float]) -> float:
    return float(np.linalg.norm(np.subtract(pose.position_m, pivot)))


@given(upright(), ANGLES, ANGLES)
def test_orbiting_keeps_the_distance_and_the_pivot_in_the_middle(start, turn, tilt):
    pose, pivot = start
    found = orbited(pose, pivot, turn, tilt)
    radius = arm_m(pose, pivot)
    assert arm_m(found, pivot) == pytest.approx(radius)
    seen = found.world_to_camera @ (*pivot, 1.0)
    np.testing.assert_allclose(seen[:2], 0, atol=1e-6)
    assert seen[2] == pytest.approx(-radius)
    assert found.turn[1, 1] > 0  # never upside down
    assert found.turn[1, 0] == pytest.approx(0.0, abs=1e-9)


@given(upright(), st.floats(-1, 1))
def test_orbiting_back_comes_back(start, turn):
    pose, pivot = start
    there = orbited(pose, pivot, turn, 0.0)
    back = orbited(there, pivot, -turn, 0.0)
    np.testing.assert_allclose(back.camera_to_world, pose.camera_to_world, atol=1e-6)


def test_to_the_right_and_up_are_that():
    pose = looking_at((0, 0, 5), (0, 0, 0))
    assert orbited(pose, (0.0, 0.0, 0.0), 0.1, 0.0).position_m[0] > 0
    assert orbited(pose, (0.0, 0.0, 0.0), 0.0, 0.1).position_m[1] > 0


def test_a_camera_that_stands_in_its_pivot_stays():
    assert orbited(Pose(), (0.0, 0.0, 0.0), 1.0, 1.0) == Pose()


@given(upright(), METRES, METRES)
def test_aside_looks_the_same_way(start, right, up):
    pose, _ = start
    found = panned(pose, right, up)
    np.testing.assert_allclose(found.turn, pose.turn, atol=1e-9)
    by = pose.turn.T @ np.subtract(found.position_m, pose.position_m)
    np.testing.assert_allclose(by, (right, up, 0), atol=1e-9)


@given(upright(), st.floats(-5, 5))
def test_dollying_leaves_a_share_of_the_way_and_never_goes_through(start, share):
    pose, pivot = start
    found = dollied(pose, pivot, share)
    np.testing.assert_allclose(found.turn, pose.turn, atol=1e-9)
    left = max(1 - share, 0.05)
    assert arm_m(found, pivot) == pytest.approx(left * arm_m(pose, pivot), rel=1e-6)


@given(upright())
def test_the_pivot_is_straight_ahead(start):
    pose, pivot = start
    np.testing.assert_allclose(pivot_of(pose, arm_m(pose, pivot)), pivot, atol=1e-6)


# What of a scene is seen

TWO = scene_of([box()], [(0, moved(-2.0)), (0, moved(3.0, 1.0, -4.0, 2.0))])


def test_bounds_are_those_of_all_corners():
    np.testing.assert_allclose(bounds_m(TWO, 1), [(-2.5, -0.5, -5), (4, 2, 0.5)])
    np.testing.assert_allclose(bounds_m(TWO, 1, "thing 1"), [(2, 0, -5), (4, 2, -3)])
    assert np.isnan(bounds_m(TWO, 1, "nothing")).all()
    assert object_names(TWO) == ("thing 0", "thing 1")


def test_the_depth_of_an_object_is_that_of_its_middle_along_the_axis():
    pose = looking_at((0, 1, 6), (0, 1, 0))
    assert object_depth_m(TWO, "thing 1", pose, 1) == pytest.approx(10.0)
    with pytest.raises(InputError, match="'no such'"):
        object_depth_m(TWO, "no such", pose, 1)
    with pytest.raises(InputError, match="behind the camera"):
        object_depth_m(TWO, "thing 1", looking_at((0, 1, -6), (0, 1, -9)), 1)


def test_bounds_leave_out_vertices_of_no_triangle_and_follow_what_moves():
    mesh = box()
    stray = replace(mesh, positions_m=np.r_[mesh.positions_m, [[99, 99, 99]]].astype(np.float32))
    turned = np.eye(4)
    turned[:3, :3] = [[0, 0, 3], [0, 1, 0], [-1, 0, 0]]
    scene = scene_of([stray, box((1, 2, 3))], motion=lambda f: np.stack([moved(f), turned]))
    np.testing.assert_allclose(bounds_m(scene, 7, "thing 0"), [(6.5, -0.5, -0.5), (7.5, 0.5, 0.5)])
    np.testing.assert_allclose(bounds_m(scene, 0, "thing 1"), [(-9, -2, -1), (9, 2, 1)])
    assert corners_m(scene, 0).shape == (16, 3) and corners_m(scene, 0, "nothing").shape == (0, 3)


@given(upright(), st.floats(0.2, 5), st.lists(PLACES, min_size=2, max_size=9), st.booleans())
def test_framed_points_are_all_in_the_picture_and_one_touches_the_margin(
    start, aspect, points, is_turned
):
    turn = start[0].turn
    points = np.array(points)
    width = 900
    size = (width, max(1, round(width / aspect)))
    pose = framed(points, LENS, size[0] / size[1], turn if is_turned else None)
    sides = (points - (points.min(axis=0) + points.max(axis=0)) / 2) @ pose.turn
    assume(np.abs(sides[:, :2]).max() > 0.01 * np.ptp(points))  # not a line seen from its end
    if is_turned:
        np.testing.assert_allclose(pose.turn, turn, atol=1e-9)
    bounds = np.array([points.min(axis=0), points.max(axis=0)])
    view = view_of(pose, LENS, size, bounds)
    clip = np.c_[points, np.ones(len(points))] @ view.clip_from_world.T
    assert (clip[:, 3] > 0).all()
    assert np.abs(clip[:, :2] / clip[:, 3:]).max() == pytest.approx(1 / 1.15, rel=1e-6)
    middle = pose.world_to_camera @ (*bounds.mean(axis=0), 1.0)
    np.testing.assert_allclose(middle[:2], 0, atol=1e-6)


@pytest.mark.parametrize("extent", [(0, 0, 0), (0, 0, 5), (1e-9, 0, 0), (1e6, 1e6, 0)])
def test_a_point_and_a_line_from_its_end_are_seen_from_outside(extent):
    points = np.array([(0, 0, 0), extent], float)
    pose = framed(points, LENS, 1.5, np.eye(3))
    assert (points[:, 2] < pose.position_m[2]).all()


@given(upright(), PLACES, st.tuples(*[st.floats(-1, 1)] * 2), st.floats(0.5, 100))
def test_a_view_shifts_points_as_the_thin_lens_does(start, point, offset, focus_m):
    """By F u (1/S - 1/z), which at the rim is the radius of the blur of the shot's lens."""
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


def test_rows_run_down_and_the_middle_is_in_the_middle():
    pose = looking_at((0, 0, 5), (0, 0, 0))
    view = view_of(pose, LENS, (200, 100), np.array([[-1.0] * 3, [1.0] * 3]))
    assert pixel(view, (0, 0, 0)) == pytest.approx((100, 50))
    x, y = pixel(view, (0.5, 0.5, 0))
    assert x > 100 and y < 50
    np.testing.assert_allclose(view.eye_m, (0, 0, 5))


STILL = CameraTrack((PoseKey(1, looking_at((0, 1, 9), (0, 0, 0))),))


def test_a_camera_of_the_shot_goes_before_one_of_the_scene():
    other = CameraTrack((PoseKey(1, looking_at((9, 1, 0), (0, 0, 0))),))
    cameras = (SceneCamera("one", STILL, 24.0, 24.0), SceneCamera("two", other, 85.0, 36.0))
    scene = scene_of([box()], cameras=cameras)
    assert track_of(scene, Framing(), LENS) == STILL
    assert track_of(scene, Framing(camera="two"), LENS) == other
    assert track_of(scene, Framing(camera="two", track=STILL), LENS) == STILL
    with pytest.raises(InputError, match="three"):
        track_of(scene, Framing(camera="three"), LENS)
    assert started_framing(scene) == Framing(camera="one")


def test_without_a_camera_the_whole_of_a_small_scene_is_seen():
    small = scene_of([box()], [(0, moved(-1.0)), (0, moved(0.7, 0.5, -1.0, 0.5))])
    assert started_framing(small) == Framing()
    pose = track_of(small, Framing(), LENS).pose_at(1)
    view = view_of(pose, LENS, (640, 360), bounds_m(small, 1))
    at = np.array([pixel(view, corner) for corner in corners_m(small, 1)]) / (640, 360)
    assert (at > 0).all() and (at < 1).all()
    assert np.abs(2 * at - 1).max() > 0.85  # and is no smaller than it has to be
