"""Test that the near plane is as far as the visible geometry allows, for depth precision."""

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.camera_track import CameraTrack, Pose, PoseKey, pose_looking_at
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.settings import DefocusSettings, Method
from heatlens.core.model.shot.shot import Shot
from heatlens.media.scene.demo import demo_scene, demo_shot
from heatlens.media.scene.scene import SceneCamera
from heatlens.media.scene.scene_bounds import (
    bounds_m,
    box_around,
    box_corners_m,
    corners_of,
    track_of,
)
from heatlens.media.scene.scene_view import nearest_visible_m, view_of, with_near_plane
from support.scenes import NIGHT, lamp, placement, plane, scene_of

LENS = Lens(50.0, 2.0, 3.0, 36.0)
METRES = st.floats(-8, 8)
BOXES = st.lists(st.tuples(METRES, METRES, METRES, METRES, METRES, METRES), min_size=1, max_size=4)
OFFSETS = st.tuples(st.floats(-0.7, 0.7), st.floats(-0.7, 0.7))


@given(BOXES, OFFSETS, st.sampled_from([0.0, 0.02, 0.5]), st.sampled_from([0.4, 3.0, np.inf]))
def test_nearest_seen_is_not_beyond_any_visible_point(values, offset, radius_m, focus_m):
    ends = np.array(values).reshape(-1, 2, 3)
    boxes = np.sort(ends, axis=1)
    corners = corners_of(boxes)
    lens = replace(LENS, focus_distance_m=focus_m)
    view = view_of(Pose(), lens, (160, 90), box_around(corners))
    nearest = nearest_visible_m(view, corners, radius_m)
    rng = np.random.default_rng(5)
    points = (
        boxes[:, :1] + rng.random((len(boxes), 4000, 3)) * np.ptp(boxes, axis=1)[:, None]
    ).reshape(-1, 3)
    points = points[points[:, 2] < -1e-3]
    through = replace(view, offset_m=(offset[0] * radius_m, offset[1] * radius_m))
    clip = np.c_[points, np.ones(len(points))] @ through.clip_from_world.T
    is_seen = (np.abs(clip[:, :2]) <= clip[:, 3:]).all(axis=1)
    assert (-points[is_seen, 2] >= nearest - 1e-6).all()


def test_nearest_seen_of_ground_is_where_the_image_begins():
    ground = corners_of(np.array([[[-50.0, -1.0, -80.0], [50.0, -1.0, 20.0]]]))
    view = view_of(Pose(), LENS, (160, 90), box_around(ground))
    begins_m = view.focal_px / 46  # 1 m down; the picture's lower edge and a pixel of room
    assert np.isclose(nearest_visible_m(view, ground, 0.0), begins_m)
    assert with_near_plane(view, begins_m).near_m == 0.99 * begins_m
    assert with_near_plane(view, -3.0).near_m == view.near_m
    assert with_near_plane(view, np.inf).near_m < view.far_m


def test_nearest_seen_of_demo_is_far_from_camera():
    scene, shot = demo_scene(), demo_shot()
    for frame in (1, 120, 240):
        lens, corners = shot.lens_at(frame), box_corners_m(scene, frame)
        pose = track_of(scene, shot.framing or Framing(), lens).pose_at(frame)
        view = view_of(pose, lens, (320, 180), bounds_m(scene, frame))
        assert nearest_visible_m(view, corners, 0.0125) > 0.5 > 50 * view.near_m


def test_window_just_before_far_wall_is_drawn_over_near_ground(renderer):
    """A near plane at a ten-thousandth of the far one would resolve 80 m and 80.05 m at best."""
    camera = SceneCamera(
        "ahead", CameraTrack((PoseKey(1, pose_looking_at((0, 0, 0), (0, 0, -1))),))
    )
    turn = np.eye(4)
    turn[:3, :3] = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
    places = [(0, placement(y=-1) @ turn), (1, placement(z=-79.98)), (2, placement(z=-80.0))]
    meshes = (plane(80.0), plane(6.0, material=1), plane(60.0, material=2))
    materials = (lamp((0.1, 0.1, 0.1)), lamp((0.8, 0.6, 0.2)), lamp((0.0, 0.0, 0.2)))
    renderer.load_scene(scene_of(meshes, places, materials, daylight=NIGHT, cameras=(camera,)))
    shot = Shot(LENS, DefocusSettings(), framing=Framing(96, 64, camera="ahead"))
    color = renderer.load_pinhole(shot, views=1).plate.color
    window = color[25:32, 42:54]
    np.testing.assert_allclose(window[..., 0], 0.8, rtol=1e-3)
    many = replace(shot, defocus=DefocusSettings(method=Method.ACCUMULATION, views=4))
    assert renderer.pixels(many)[25:31, 44:52, 0].min() > 0.79
