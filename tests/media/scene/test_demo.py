"""Test the built-in scene: actors at their focus marks, smooth motion, and a small file."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from demo_street.actors import LOOP_FRAMES, joints_at
from demo_street.make import ACTORS, street_bytes
from heatlens.core.model.marks.marks import DistanceMark
from heatlens.media.scene.demo import demo_scene, demo_shot
from heatlens.media.scene.gltf.read import read_gltf
from heatlens.media.scene.scene_bounds import bounds_m, object_names, track_of
from heatlens.media.scene.scene_view import view_of

SCENE, SHOT = demo_scene(), demo_shot()
FRAMES = SHOT.frames
assert FRAMES is not None and SHOT.framing is not None
TRACK = track_of(SCENE, SHOT.framing, SHOT.lens)
frames = st.floats(FRAMES.first, FRAMES.last)
actors = st.sampled_from(sorted(ACTORS))


def position_in_camera(name: str, frame: float) -> np.ndarray:
    """Return the middle (3,) of an actor in the camera's axes."""
    body = joints_at(ACTORS[name], frame)["body"][:, 3]
    return (TRACK.pose_at(frame).world_to_camera @ body)[:3]


def focus_keys() -> list[tuple[float, str]]:
    """Return the frame of each focus key and the actor whose mark it is on."""
    actor = {
        mark.distance_m: f"actor {mark.name}"
        for mark in SHOT.marks
        if isinstance(mark, DistanceMark)
    }
    return [(key.frame, actor[key.value]) for key in SHOT.curves.focus_distance_m.keys]


def test_demo_focus_keys_go_from_mark_to_mark() -> None:
    assert [name[-1] for _, name in focus_keys()] == ["A", "B", "B", "C"]
    assert all(frame in FRAMES for frame, _ in focus_keys())


@pytest.mark.parametrize(("frame", "name"), focus_keys())
def test_demo_actor_is_at_focus_distance_at_each_key(frame: float, name: str) -> None:
    focus = SHOT.lens_at(frame).focus_distance_m
    assert -position_in_camera(name, frame)[2] == pytest.approx(focus, abs=0.1)


@pytest.mark.parametrize(
    ("name", "first", "last"), [("actor A", 1, 60), ("actor B", 88, 150), ("actor C", 190, 240)]
)
def test_demo_actor_in_focus_stays_in_focus_and_in_frame(name: str, first: int, last: int) -> None:
    half_width = SHOT.lens.sensor_width_mm / (2 * SHOT.lens.focal_length_mm)
    for frame in range(first, last + 1):
        x, _, z = position_in_camera(name, frame)
        assert -z == pytest.approx(SHOT.lens_at(frame).focus_distance_m, abs=0.15)
        assert abs(x) < half_width * -z


def test_demo_has_lens_and_view_at_every_frame() -> None:
    size = SHOT.framing.size
    for frame in FRAMES:
        lens = SHOT.lens_at(frame)
        view = view_of(TRACK.pose_at(frame), lens, size, bounds_m(SCENE, frame))
        assert 0 < view.near_m < lens.focus_distance_m < view.far_m < 200


@given(frames, st.sampled_from([1, -1, 2]))
def test_demo_motion_is_a_loop(frame: float, turns: int) -> None:
    later = SCENE.transforms_at(frame + turns * LOOP_FRAMES)
    np.testing.assert_allclose(later, SCENE.transforms_at(frame), atol=1e-9)


def test_demo_motion_has_no_jumps() -> None:
    """The steps include the one from the last frame to the first."""
    points = np.array([(0, 0, 0, 1), (0, -0.4, 0, 1), (0.1, 0, 0, 1), (0, 0, 0.1, 1.0)]).T
    places = np.stack([(SCENE.transforms_at(f) @ points)[:, :3] for f in (*FRAMES, FRAMES.first)])
    steps = np.linalg.norm(np.diff(places, axis=0), axis=2)
    assert steps.max() < 0.25  # metres; who runs has 8 m/s in the foot
    moving = [i for i, instance in enumerate(SCENE.instances) if instance.name in ACTORS]
    assert steps[:, moving].max(axis=(0, 2)).min() > 0.01
    assert not np.delete(steps, moving, axis=1).any()


@given(actors, frames)
def test_demo_actors_have_feet_on_ground_and_rigid_limbs(name: str, frame: float) -> None:
    joints = joints_at(ACTORS[name], frame)
    for matrix in joints.values():
        np.testing.assert_allclose(matrix[:3, :3].T @ matrix[:3, :3], np.eye(3), atol=1e-9)
    ankles = [joints[f"{side} shin"] @ (0, -0.43, 0, 1) for side in ("left", "right")]
    assert min(ankle[1] for ankle in ankles) == pytest.approx(0.08, abs=1e-9)
    assert max(ankle[1] for ankle in ankles) < 0.45
    assert 0.85 < joints["body"][1, 3] <= 0.9401


@given(actors, frames)
def test_demo_actors_face_their_walking_direction(name: str, frame: float) -> None:
    walk = ACTORS[name]
    ahead = np.subtract(walk.place_at(frame + 1e-3), walk.place_at(frame - 1e-3))
    face = np.array([np.sin(walk.heading_at(frame)), np.cos(walk.heading_at(frame))])
    np.testing.assert_allclose(ahead / np.linalg.norm(ahead), face, atol=1e-4)


def test_demo_scene_is_small_and_complete() -> None:
    assert 5_000 <= SCENE.triangle_count <= 15_000
    assert {*ACTORS, "railing", "table", "garlands", "street lamps"} <= {*object_names(SCENE)}
    assert len(SCENE.meshes) < len(SCENE.instances)
    for mesh in SCENE.meshes:
        assert mesh.triangles.max() < len(mesh.positions_m)
        assert 0 <= mesh.material < len(SCENE.materials)
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=1e-5)
    brightest = max(max(material.emission) for material in SCENE.materials)
    assert 50 <= brightest <= 500


def test_demo_normals_point_outward() -> None:
    """Faces and normals agree; otherwise a shape would be lit from the wrong side."""
    for mesh in SCENE.meshes:
        a, b, c = (mesh.positions_m[mesh.triangles[:, i]] for i in range(3))
        facing = np.cross(b - a, c - a)
        agree = np.sum(facing * mesh.normals[mesh.triangles].mean(axis=1), axis=1) > 0
        assert agree.all()


def test_demo_file_equals_output_of_its_scripts(tmp_path: Path) -> None:
    """The last digits of the walks are ignored, because they differ between processors."""
    path = tmp_path / "street.glb"
    path.write_bytes(street_bytes())
    generated = read_gltf(path)
    assert generated.materials == SCENE.materials and generated.lights == SCENE.lights
    assert [(i.name, i.mesh) for i in generated.instances] == [
        (i.name, i.mesh) for i in SCENE.instances
    ]
    np.testing.assert_array_equal(generated.images[0], SCENE.images[0])
    for of_script, of_file in zip(generated.meshes, SCENE.meshes, strict=True):
        np.testing.assert_allclose(of_script.positions_m, of_file.positions_m, atol=1e-6)
        np.testing.assert_allclose(of_script.normals, of_file.normals, atol=1e-5)
        np.testing.assert_array_equal(of_script.triangles, of_file.triangles)
    for frame in (1.0, 77.3, 240.0):
        np.testing.assert_allclose(
            generated.transforms_at(frame), SCENE.transforms_at(frame), atol=1e-6
        )


@given(frames)
def test_demo_motion_curves_follow_the_walk(frame: float) -> None:
    """They agree within 4 mm between keys; a pixel of the nearest person is 2 mm wide."""
    numbers = [i for i, one in enumerate(SCENE.instances) if one.name == "actor A"]
    followed = joints_at(ACTORS["actor A"], frame)
    at = SCENE.transforms_at(frame)[numbers[0]]  # the first part of a person is the coat
    np.testing.assert_allclose(at[:3, 3], followed["body"][:3, 3], atol=4e-3)
