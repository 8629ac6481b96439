"""Cameras, lights and movement of glTF files, against what was written and against laws."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.camera_track import pose_looking_at
from heatlens.media.scene.gltf.value_track import ValueTrack
from heatlens.media.scene.scene_read import read_scene
from support.gltf_files import GltfWriter, square_scene


@pytest.fixture
def path(tmp_path):
    return tmp_path / "scene.glb"


def with_camera(writer, node=(), **perspective):
    """Return a square scene with a camera more."""
    perspective = {"yfov": 0.5, "aspectRatio": 1.5, "znear": 0.1} | perspective
    camera = writer.add("cameras", type="perspective", perspective=perspective)
    return writer.node(**{"camera": camera, "name": "hero", **dict(node)})


def test_gltf_camera_angle_gives_focal_length(path):
    writer = square_scene()
    with_camera(writer, yfov=0.6, aspectRatio=2.0)
    (camera,) = read_scene(writer.write(path)).cameras
    height_mm = camera.sensor_width_mm / 2.0
    assert 2 * np.arctan(height_mm / 2 / camera.focal_length_mm) == pytest.approx(0.6)
    assert camera.sensor_width_mm == 36.0


def test_gltf_cameras_have_unique_names(path):
    writer = square_scene()
    for place in ([1, 0, 0], [2, 0, 0]):
        with_camera(writer, {"translation": place})
    with_camera(writer, {"name": "other"})
    parallel = writer.add("cameras", type="orthographic", orthographic={})
    writer.node(camera=parallel, name="plan")
    scene = read_scene(writer.write(path))
    assert [camera.name for camera in scene.cameras] == ["hero", "hero 2", "other"]
    assert scene.camera_named("hero 2").track.pose_at(1).position_m == (2, 0, 0)
    assert "'plan'" in " ".join(scene.notes)


def test_gltf_camera_pose_includes_parent_nodes(path):
    writer = square_scene()
    pose = pose_looking_at((1, 2, 3), (0, 0, 0))
    w, x, y, z = pose.orientation
    node = {"rotation": [x, y, z, w], "translation": [1, 2, 3]}
    with_camera(writer, node)
    writer.json["scenes"][0]["nodes"].remove(1)
    writer.node(scale=[2, 2, 2], translation=[0, 0, 1], children=[1])
    found = read_scene(writer.write(path)).cameras[0].track.pose_at(1)
    assert found.position_m == pytest.approx((2, 4, 7))
    assert found.orientation == pytest.approx(pose.orientation)


def test_gltf_lights_of_every_kind_are_read(path):
    writer = square_scene()
    down = {"rotation": [-np.sqrt(0.5), 0, 0, np.sqrt(0.5)]}  # -z becomes -y
    sun = writer.light(type="directional", color=[1, 0.5, 0.25], intensity=4)
    lamp = writer.light(type="point", intensity=10)
    spot = writer.light(type="spot", spot={"innerConeAngle": 0.2, "outerConeAngle": 0.4})
    writer.node(**sun, **down)
    writer.node(**lamp, translation=[1, 2, 3])
    writer.node(**spot, **down)
    scene = read_scene(writer.write(path))
    assert scene.daylight.sun == (4, 2, 1)
    assert scene.daylight.to_sun == pytest.approx((0, 1, 0), abs=1e-9)
    point, cone = scene.lights
    assert (point.position_m, point.intensity, point.direction) == ((1, 2, 3), (10,) * 3, None)
    assert cone.direction == pytest.approx((0, -1, 0), abs=1e-9)
    assert cone.cone_cosines == pytest.approx((np.cos(0.2), np.cos(0.4)))


def test_gltf_sun_is_off_if_file_has_other_lights(path):
    assert read_scene(square_scene().write(path)).daylight.sun != (0, 0, 0)
    writer = square_scene()
    writer.node(**writer.light(type="point"))
    assert read_scene(writer.write(path)).daylight.sun == (0, 0, 0)


def test_gltf_brightest_of_several_suns_is_taken(path):
    writer = square_scene()
    for strength in (1, 3, 2):
        writer.node(**writer.light(type="directional", intensity=strength))
    scene = read_scene(writer.write(path))
    assert scene.daylight.sun == (3, 3, 3)
    assert "brightest" in " ".join(scene.notes)


def test_gltf_animation_starts_at_frame_one_at_24_fps(path):
    writer = square_scene()
    writer.animate(0, "translation", [0, 1, 2], [[0, 0, 0], [24, 0, 0], [24, 12, 0]])
    scene = read_scene(writer.write(path))
    assert scene.frames == FrameRange(1, 49)
    at = [scene.transforms_at(frame)[0, :3, 3].tolist() for frame in (-5, 1, 2, 25, 37, 49, 99)]
    still, end = [0, 0, 0], [24, 12, 0]
    assert np.allclose(at, [still, still, [1, 0, 0], [24, 0, 0], [24, 6, 0], end, end])


def test_gltf_step_interpolation_holds_until_next_key(path):
    writer = square_scene()
    writer.animate(0, "scale", [0, 1], [[1, 1, 1], [3, 3, 3]], "STEP")
    scene = read_scene(writer.write(path))
    assert [scene.transforms_at(f)[0, 0, 0] for f in (1, 24.9, 25)] == [1, 1, 3]


def test_gltf_child_moves_with_its_animated_parent(path):
    writer = GltfWriter()
    leaf = writer.node(is_root=False, mesh=writer.mesh(), translation=[1, 0, 0])
    root = writer.node(children=[leaf])
    turn = Rotation.from_rotvec([0, 0, np.pi / 2]).as_quat()
    writer.animate(root, "rotation", [0, 1], [[0, 0, 0, 1], turn])
    scene = read_scene(writer.write(path))
    assert scene.transforms_at(25)[0, :3, 3] == pytest.approx([0, 1, 0], abs=1e-6)
    half = np.sqrt(0.5)
    assert scene.transforms_at(13)[0, :3, 3] == pytest.approx([half, half, 0], abs=1e-6)


def test_gltf_moving_camera_has_key_per_frame(path):
    writer = square_scene()
    node = with_camera(writer)
    writer.animate(node, "translation", [0, 1], [[0, 0, 5], [0, 0, 29]])
    scene = read_scene(writer.write(path))
    keys = scene.cameras[0].track.keys
    assert [key.frame for key in keys] == list(range(1, 26))
    assert [key.pose.position_m[2] for key in keys] == pytest.approx(list(range(5, 30)))
    assert (scene.motion, scene.frames) == (None, FrameRange(1, 25))


def test_gltf_first_of_two_animations_of_a_node_is_played(path):
    writer = square_scene()
    for far in (1, 2):
        writer.animate(0, "translation", [0, 1], [[0, 0, 0], [far, 0, 0]])
    scene = read_scene(writer.write(path))
    assert scene.transforms_at(25)[0, 0, 3] == 1
    assert "the first is played" in " ".join(scene.notes)


turns = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1)


@given(turns, turns, st.floats(0, 1))
def test_value_track_rotates_evenly_along_shorter_arc(first, last, share):
    rows = np.array([first, last]) / np.linalg.norm([first, last], axis=1, keepdims=True)
    if abs(rows[0] @ rows[1]) < 1e-3:
        return  # half a turn: either way is as short
    track = ValueTrack(np.array([0.0, 1.0]), rows, is_rotation=True)
    expected = Slerp([0, 1], Rotation.from_quat(rows))(share)
    found = Rotation.from_quat(track.sample(np.array([share]))[0])
    assert (found * expected.inv()).magnitude() < 1e-5


@given(st.lists(st.tuples(*[st.floats(-9, 9)] * 3), min_size=2, max_size=5), st.floats(-1, 9))
def test_value_track_cubic_spline_is_hermite(keys, time):
    from scipy.interpolate import CubicHermiteSpline  # here: costs every worker a second to collect

    times = np.cumsum(np.arange(1.0, len(keys) + 1))
    values = np.array(keys)[:, :, None]
    track = ValueTrack(times_s=times, values=values, kind="CUBICSPLINE")
    inside = np.clip(time, times[0], times[-1])
    slopes = np.column_stack([values[:-1, 2, 0], values[1:, 0, 0]])
    i = min(np.searchsorted(times, inside, "right") - 1, len(times) - 2)
    spline = CubicHermiteSpline(times[i : i + 2], values[i : i + 2, 1, 0], slopes[i])
    assert track.sample(np.array([time]))[0, 0] == pytest.approx(float(spline(inside)), abs=1e-9)


@pytest.mark.parametrize(
    ("times", "path_moved", "kind", "words"),
    [
        ([0, -1], "translation", "LINEAR", "rise"),
        ([0, 5000], "translation", "LINEAR", "frames"),
        ([0, 1], "translation", "WAVY", "not an interpolation"),
        ([0, 1], "rotation", "LINEAR", "4 number"),
        ([0, 1, 2], "translation", "LINEAR", "do not match"),
    ],
)
def test_gltf_invalid_animation_is_rejected(path, times, path_moved, kind, words):
    writer = square_scene()
    writer.animate(0, path_moved, times, [[0, 0, 0], [1, 0, 0]], kind)
    with pytest.raises(InputError, match=rf"scene\.glb.*{words}"):
        read_scene(writer.write(path))
