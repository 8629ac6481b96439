"""Test skins and blend shapes: each vertex is where the formula of glTF puts it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.pupil import PINHOLE
from heatlens.core.model.shot.framing import SceneTiming
from heatlens.media.scene.scene import Scene
from heatlens.media.scene.scene_bounds import bounds_m
from heatlens.media.scene.scene_read import read_scene
from heatlens.media.scene.scene_view import SceneView
from heatlens.render.gpu.textures import download, new_texture
from heatlens.render.scene_gpu.bvh import build_mesh_trees, refit_tree
from heatlens.render.scene_gpu.raster import SceneRaster
from heatlens.render.scene_gpu.ray_tracer import RayTracer
from support.gltf_files import SQUARE, SQUARE_CORNERS, GltfWriter
from support.scenes import NIGHT, lamp, plane, scene_of, sphere

UP = np.tile(np.float32([0, 0, 1]), (4, 1))
AWAY = [[0, 0, 0], [6, 0, 0]]


def skinned_square(shares, attributes=(), joints=None, matrices=None):
    """Return a square on two bones, the second moving 6 m in a second; `shares` is (4, 2)."""
    writer = GltfWriter()
    weights = np.pad(np.float32(shares), ((0, 0), (0, 2)))
    numbers = np.tile(np.uint8([0, 1, 0, 0]), (4, 1)) if joints is None else joints
    attributes_by_name = {
        "NORMAL": UP,
        "JOINTS_0": numbers,
        "WEIGHTS_0": weights,
        **dict(attributes),
    }
    mesh = writer.mesh(SQUARE, SQUARE_CORNERS, attributes_by_name)
    bones = [writer.node(translation=[0, 1, 0]), writer.node()]
    skin = {"joints": bones}
    if matrices is not None:
        data = np.float32(matrices).transpose(0, 2, 1).tobytes()
        skin["inverseBindMatrices"] = writer.add(
            "accessors", bufferView=writer.view(data), componentType=5126, count=2, type="MAT4"
        )
    writer.add("skins", **skin)
    # Where the node of a mesh on bones stands is of no account.
    writer.node(mesh=mesh, skin=0, translation=[77, 0, 0])
    writer.animate(bones[1], "translation", [0, 1], AWAY)
    return writer


def world_vertices(scene: Scene, frame: float):
    """Return the square's vertices in the world."""
    mesh = scene.shapes_at(frame)[0] if scene.deforms else scene.meshes[0]
    return (
        mesh.positions_m @ scene.transforms_at(frame)[0, :3, :3].T
        + (scene.transforms_at(frame)[0, :3, 3])
    )


@given(st.lists(st.floats(0, 1, width=32), min_size=4, max_size=4), st.integers(1, 25))
def test_skin_moves_vertex_to_weighted_mean_of_bones(tmp_path_factory, shares, frame):
    rows = np.column_stack([1 - np.array(shares), shares])
    path = skinned_square(rows).write(tmp_path_factory.mktemp("skin") / "a.glb")
    scene = read_scene(path)
    moved = [6 * (frame - 1) / 24, 0, 0]
    expected = SQUARE + rows[:, :1] * [0, 1, 0] + rows[:, 1:] * moved
    np.testing.assert_allclose(world_vertices(scene, frame), expected, atol=1e-5)
    assert scene.frames.last == 25 and scene.is_moving and scene.motion is None


def test_skin_applies_inverse_bind_matrices(tmp_path):
    inverse = np.tile(np.eye(4), (2, 1, 1))
    inverse[0, 1, 3] = -1.0
    scene = read_scene(skinned_square([[1, 0]] * 4, matrices=inverse).write(tmp_path / "a.glb"))
    np.testing.assert_allclose(world_vertices(scene, 13), SQUARE, atol=1e-6)
    np.testing.assert_allclose(bounds_m(scene, 13), [[0, 0, 0], [1, 1, 0]], atol=1e-6)


def test_scene_bounds_follow_skin(tmp_path):
    scene = read_scene(skinned_square([[0, 1]] * 4).write(tmp_path / "a.glb"))
    np.testing.assert_allclose(bounds_m(scene, 25), [[6, 0, 0], [7, 1, 0]], atol=1e-5)


@pytest.mark.parametrize(
    ("broken", "words"),
    [
        ({"joints": np.full((4, 4), 9, np.uint8)}, "bone 9 of 2"),
        ({"attributes": {"WEIGHTS_0": np.ones((3, 4), np.float32)}}, "3 of WEIGHTS_0"),
    ],
)
def test_skin_with_bad_joints_or_weights_is_rejected(tmp_path, broken, words):
    with pytest.raises(InputError, match=rf"a\.glb.*{words}"):
        read_scene(skinned_square([[1, 0]] * 4, **broken).write(tmp_path / "a.glb"))


# Shapes that blend


def blending_square(weights=None, on_node=None, animated=False, normals=True):
    """Return a square with two shapes: one lifts all by 1 m, one moves its first corner by 2 m."""
    writer = GltfWriter()
    mesh = writer.mesh(SQUARE, SQUARE_CORNERS, {"NORMAL": UP} if normals else {})
    corner = np.zeros((4, 3), np.float32)
    corner[0, 0] = -2
    targets = [{"POSITION": writer.accessor(shape)} for shape in (UP, corner)]
    record = writer.json["meshes"][mesh]
    record["primitives"][0]["targets"] = targets
    if weights is not None:
        record["weights"] = weights
    node = writer.node(mesh=mesh, **({} if on_node is None else {"weights": on_node}))
    if animated:
        writer.animate(node, "weights", [0, 1], [0, 0, 1, 0.5])
        writer.json["accessors"][-1] |= {"type": "SCALAR"}
    return writer


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({}, (0, 0)),
        ({"weights": [0.5, 0]}, (0.5, 0)),
        ({"weights": [0.5, 0], "on_node": [0, 1]}, (0, 1)),
    ],
)
def test_blend_shapes_are_added_by_weight(tmp_path, options, expected):
    scene = read_scene(blending_square(**options).write(tmp_path / "a.glb"))
    lifted = SQUARE + expected[0] * UP
    lifted[0, 0] -= 2 * expected[1]
    np.testing.assert_allclose(scene.meshes[0].positions_m, lifted)
    assert not scene.is_moving


@pytest.mark.parametrize("normals", [True, False])
def test_blend_shapes_change_over_frames(tmp_path, normals):
    scene = read_scene(blending_square(animated=True, normals=normals).write(tmp_path / "a.glb"))
    for frame, share in ((1, 0.0), (13, 0.5), (25, 1.0)):
        mesh = scene.shapes_at(frame)[0]
        lifted = SQUARE + share * UP
        lifted[0, 0] -= share
        found = mesh.positions_m[mesh.triangles].reshape(-1, 3)
        np.testing.assert_allclose(found, lifted[SQUARE_CORNERS], atol=1e-6)
        np.testing.assert_allclose(mesh.normals, np.tile(UP[:1], (len(mesh.normals), 1)), atol=1e-6)


def test_blend_weights_that_do_not_match_keys_are_rejected(tmp_path):
    writer = blending_square(animated=True)
    writer.json["accessors"][-1]["count"] = 3
    with pytest.raises(InputError, match="3 weights cannot belong to 2"):
        read_scene(writer.write(tmp_path / "a.glb"))


# Clips and frames


def writer_with_clips():
    writer = GltfWriter()
    node = writer.node(mesh=writer.mesh())
    for name, far in (("walk", 1), ("run", 5)):
        writer.animate(node, "translation", [1, 2], [[0, 0, 0], [far, 0, 0]])
        writer.json["animations"][-1]["name"] = name
    return writer


@pytest.mark.parametrize(("clip", "far"), [(None, 1), ("walk", 1), ("run", 5), ("2", 5)])
def test_read_scene_selects_clip_by_name_or_number(tmp_path, clip, far):
    scene = read_scene(writer_with_clips().write(tmp_path / "a.glb"), SceneTiming(clip))
    assert scene.transforms_at(scene.frames.last)[0, 0, 3] == pytest.approx(far)
    assert scene.clips == ("walk", "run")
    assert ("--clip" in " ".join(scene.notes)) == (clip is None)


def test_read_scene_reports_unknown_clip(tmp_path):
    with pytest.raises(InputError, match=r"no clip 'fly'"):
        read_scene(writer_with_clips().write(tmp_path / "a.glb"), SceneTiming("fly"))


def test_scene_timing_hits_frames_of_given_rate_exactly(tmp_path):
    """Seconds 1 to 2 at 25 frames a second, starting at frame 101, are frames 101 to 126."""
    scene = read_scene(writer_with_clips().write(tmp_path / "a.glb"), SceneTiming("run", 25.0, 101))
    assert (scene.frames.first, scene.frames.last, scene.frames_per_second) == (101, 126, 25.0)
    for frame in range(101, 127):
        found = scene.transforms_at(frame)[0, 0, 3]
        assert found == pytest.approx(5 * (frame - 101) / 25, abs=1e-6)


def test_scene_timing_without_first_frame_starts_at_frame_one(tmp_path):
    scene = read_scene(writer_with_clips().write(tmp_path / "a.glb"), SceneTiming("run", 25.0))
    assert (scene.frames.first, scene.frames.last) == (1, 51)
    assert scene.transforms_at(26)[0, 0, 3] == 0


def test_scene_timing_is_rejected_for_other_formats(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(InputError, match="only for glTF"):
        read_scene(tmp_path / "a.obj", SceneTiming(None, 25.0))


# Drawing


def test_refitted_tree_of_same_shape_is_unchanged():
    ball = sphere(1.0, 2)
    trees = build_mesh_trees([plane(), ball])
    np.testing.assert_array_equal(refit_tree(trees, 1, ball), trees.nodes[trees.roots[1] :])


def test_refitted_tree_of_other_shape_encloses_it():
    rng = np.random.default_rng(3)
    ball = sphere(1.0, 2)
    trees = build_mesh_trees([plane(), ball])
    other_ball = replace(
        ball, positions_m=rng.normal(size=ball.positions_m.shape).astype(np.float32)
    )
    nodes, root = refit_tree(trees, 1, other_ball), int(trees.roots[1])
    np.testing.assert_array_equal(nodes["low"][0], other_ball.box_m[0].astype(np.float32))
    for node in nodes:
        if node["count"] < 0:
            for child in nodes[node["first"] - root :][:2]:
                assert (child["low"] >= node["low"]).all() and (child["high"] <= node["high"]).all()
        else:
            rows = trees.triangles[node["first"] : node["first"] + node["count"], 3]
            corners = other_ball.positions_m[other_ball.triangles[rows]]
            assert (corners.min(axis=(0, 1)) == node["low"]).all()
            assert (corners.max(axis=(0, 1)) == node["high"]).all()


def test_ray_tracer_and_raster_show_moving_shape_alike(session_context):
    ctx = session_context
    sheet = plane(1.0)

    def moved(frame):
        offset = np.float32([frame - 1, 0, -4])
        return replace(sheet, positions_m=sheet.positions_m + offset)

    scene = scene_of([moved(1)], None, [lamp((1, 1, 1))], daylight=NIGHT, deforms={0: moved})
    view = SceneView(
        world_to_camera=np.eye(4),
        size=(16, 8),
        focal_px=8.0,
        focus_m=np.inf,
        near_m=0.1,
        far_m=100.0,
    )
    raster = SceneRaster(ctx)
    raster.load(scene)
    rays, out = RayTracer(ctx, raster), new_texture(ctx, view.size, 4)
    pictures = []
    for frame in (1, 3, 1):
        raster.place(frame)
        raster.draw(view, out)
        drawn = download(out)[..., 0]
        for _ in rays.steps(view, PINHOLE, 1, out, frame, pixel_side_px=0.0):
            pass
        np.testing.assert_array_equal(download(out)[..., 0], drawn)
        pictures.append(drawn)
    assert pictures[0].sum() == pictures[1].sum() == 16  # 4 x 4 pixels
    np.testing.assert_array_equal(pictures[2], pictures[0])
    np.testing.assert_array_equal(pictures[1][:, 4:], pictures[0][:, :12])
    for resource in (rays, raster, out):
        resource.release()
