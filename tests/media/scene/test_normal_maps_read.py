"""Test reading of normal maps in glTF files and the tangents that go with them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from heatlens.core.base.errors import InputError
from heatlens.media.scene.mesh_make import add_tangents, make_mesh
from heatlens.media.scene.scene_read import read_scene
from support.gltf_files import SQUARE_UVS, GltfWriter
from support.scenes import plane, sphere

BUMPS = [[[200, 128, 240]]]
NORMALS = np.tile(np.float32([0, 0, 1]), (4, 1))
TOLD = np.tile(np.float32([0, 3, 0, -1]), (4, 1))


def square_with_normal_map(attributes=(), kind="PNG", look=(), **info) -> GltfWriter:
    """Return a square with a map of normals."""
    writer = GltfWriter()
    material = {"normalTexture": {"index": writer.picture(BUMPS, kind), **info}, **dict(look)}
    attributes = {"TEXCOORD_0": SQUARE_UVS, **dict(attributes)}
    number = writer.add("materials", **material)
    writer.node(mesh=writer.mesh(attributes=attributes, material=number))
    return writer


def write_and_read(writer, tmp_path):
    return read_scene(writer.write(tmp_path / "a.glb"))


def test_gltf_normal_map_and_scale_are_read(tmp_path):
    scene = write_and_read(square_with_normal_map({"NORMAL": NORMALS}, scale=0.25), tmp_path)
    assert (scene.materials[0].normal_map, scene.materials[0].normal_scale) == (0, 0.25)
    assert scene.images[0][0, 0, :3].tolist() == BUMPS[0][0] and not scene.notes
    np.testing.assert_allclose(scene.meshes[0].tangents, [[1, 0, 0, 1]] * 4, atol=1e-6)
    assert write_and_read(square_with_normal_map(), tmp_path).materials[0].normal_scale == 1.0


@pytest.mark.parametrize("has_normals", [True, False])
def test_gltf_tangents_are_used_only_with_normals(tmp_path, has_normals):
    normals = {"NORMAL": NORMALS} if has_normals else {}
    tangents = (
        write_and_read(square_with_normal_map({"TANGENT": TOLD, **normals}), tmp_path)
        .meshes[0]
        .tangents
    )
    assert (tangents == ([0, 1, 0, -1] if has_normals else [1, 0, 0, 1])).all()


def test_gltf_mesh_without_normal_map_has_no_tangents(tmp_path):
    writer = GltfWriter()
    attributes = {"NORMAL": NORMALS, "TANGENT": TOLD, "TEXCOORD_0": SQUARE_UVS}
    writer.node(mesh=writer.mesh(attributes=attributes))
    assert write_and_read(writer, tmp_path).meshes[0].tangents is None


@pytest.mark.parametrize(
    ("tangents", "message_part"), [(TOLD[:3], "3 of TANGENT"), (TOLD[:, :3].copy(), "VEC3")]
)
def test_gltf_invalid_tangents_are_rejected(tmp_path, tangents, message_part):
    with pytest.raises(InputError, match=message_part):
        write_and_read(square_with_normal_map({"NORMAL": NORMALS, "TANGENT": tangents}), tmp_path)


@pytest.mark.parametrize(
    ("info", "message_part"), [({"index": 7}, "only 1 of them"), ({"scale": "steep"}, "a number")]
)
def test_gltf_invalid_normal_texture_is_rejected(tmp_path, info, message_part):
    with pytest.raises(InputError, match=f"normalTexture.*{message_part}"):
        write_and_read(square_with_normal_map(**info), tmp_path)


def test_gltf_damaged_normal_map_is_left_out(tmp_path):
    writer = square_with_normal_map()
    start = writer.data.index(b"PNG")
    writer.data[start : start + 40] = bytes(40)
    scene = write_and_read(writer, tmp_path)
    assert scene.materials[0].normal_map is None and "not a picture" in scene.notes[0]


@pytest.mark.parametrize("odd", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("name", ["NORMAL", "TANGENT", "TEXCOORD_0"])
def test_gltf_single_nan_keeps_the_scene(tmp_path, name, odd):
    attributes = {"NORMAL": NORMALS.copy(), "TANGENT": TOLD.copy(), "TEXCOORD_0": SQUARE_UVS.copy()}
    attributes[name][2, 0] = odd
    scene = write_and_read(square_with_normal_map(attributes), tmp_path)
    mesh = scene.meshes[0]
    for values in (mesh.normals, mesh.tangents, mesh.uvs):
        assert np.isfinite(values).all()
    np.testing.assert_allclose(mesh.normals, NORMALS, atol=1e-6)
    assert "are NaN" in scene.notes[0]


@pytest.mark.parametrize("scale", [1e300, -1e300])
def test_gltf_huge_normal_scale_is_limited(tmp_path, scale):
    found = write_and_read(square_with_normal_map(scale=scale), tmp_path).materials[0].normal_scale
    assert np.sign(found) == np.sign(scale) and abs(found) < 1e5


def test_gltf_normal_map_with_own_uvs_keeps_its_placement(tmp_path):
    look = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
    attributes = {"TEXCOORD_1": SQUARE_UVS[:, ::-1].copy(), "NORMAL": NORMALS}
    scene = write_and_read(square_with_normal_map(attributes, look=look, texCoord=1), tmp_path)
    material, mesh = scene.materials[0], scene.meshes[0]
    assert [place.coordinates for place in material.map_places] == [0, 0, 0, 1, 0]
    np.testing.assert_array_equal(mesh.uvs, SQUARE_UVS)
    np.testing.assert_array_equal(mesh.more_uvs, SQUARE_UVS[:, ::-1])
    np.testing.assert_allclose(mesh.tangents, [[0, -1, 0, -1]] * 4, atol=1e-6)
    look["occlusionTexture"] = {"index": 0, "strength": 0.75}
    scene = write_and_read(square_with_normal_map(look=look), tmp_path)
    material = scene.materials[0]
    assert (material.normal_map, material.occlusion_map, material.occlusion) == (0, 0, 0.75)


def test_gltf_normal_map_alone_uses_its_uvs(tmp_path):
    uvs = {"TEXCOORD_1": SQUARE_UVS[:, ::-1].copy(), "NORMAL": NORMALS}
    scene = write_and_read(square_with_normal_map(uvs, texCoord=1), tmp_path)
    assert scene.materials[0].normal_map == 0 and not scene.notes
    # u runs down and v to the right: against v is to the left
    np.testing.assert_allclose(scene.meshes[0].tangents, [[0, -1, 0, -1]] * 4, atol=1e-6)


# Tangents out of uvs


def test_tangents_of_sphere_follow_its_parallels():
    ball = sphere(1.0, 3)
    ball_with_tangents = add_tangents(ball)
    inside = (np.abs(ball_with_tangents.uvs[:, 0] - 0.5) < 0.3) & (
        np.abs(ball_with_tangents.positions_m[:, 1]) < 0.8
    )
    along = np.cross([0, 1, 0], ball_with_tangents.positions_m[inside])
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    assert (np.sum(along * ball_with_tangents.tangents[inside, :3], axis=1) > 0.99).all()
    assert (ball_with_tangents.tangents[inside, 3] == 1).all()


def test_tangents_of_mirrored_halves_split_at_the_seam():
    """Half of a face is painted, and both sides of it use that image."""
    positions = np.float32([[-1, 0, 0], [0, 0, 0], [1, 0, 0], [-1, 1, 0], [0, 1, 0], [1, 1, 0]])
    uvs = np.float32([[1, 1], [0, 1], [1, 1], [1, 0], [0, 0], [1, 0]])
    corners = np.uint32([[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]])
    normals = np.tile(np.float32([0, 0, 1]), (6, 1))
    face = add_tangents(make_mesh("face", positions, corners, normals, uvs))
    assert len(face.positions_m) == 8
    assert np.array_equal(face.positions_m[face.triangles], positions[corners])
    found = face.tangents[face.triangles]
    np.testing.assert_allclose(found[:2], np.tile([-1, 0, 0, -1], (2, 3, 1)), atol=1e-6)
    np.testing.assert_allclose(found[2:], np.tile([1, 0, 0, 1], (2, 3, 1)), atol=1e-6)


def test_tangents_do_not_depend_on_corner_order():
    sheet = plane()
    reversed_sheet = make_mesh(
        "a", sheet.positions_m, sheet.triangles[:, ::-1], sheet.normals, sheet.uvs
    )
    np.testing.assert_allclose(add_tangents(reversed_sheet).tangents, add_tangents(sheet).tangents)


NUMBERS = st.floats(-1e3, 1e3, width=32)


@given(
    hnp.arrays(np.float32, (5, 3), elements=NUMBERS),
    hnp.arrays(np.float32, (5, 2), elements=NUMBERS),
    hnp.arrays(np.uint32, (4, 3), elements=st.integers(0, 4)),
)
def test_tangents_of_any_mesh_are_unit_and_perpendicular_or_zero(positions, uvs, corners):
    normals = np.tile(np.float32([0.6, 0, 0.8]), (5, 1))
    mesh = make_mesh("a", positions, corners, normals, uvs)
    mesh_with_tangents = add_tangents(mesh)
    lengths = np.linalg.norm(mesh_with_tangents.tangents[:, :3], axis=1)
    assert ((np.abs(lengths - 1) < 1e-4) | (lengths == 0)).all()
    assert (
        np.abs(
            np.sum(mesh_with_tangents.tangents[:, :3] * mesh_with_tangents.normals, axis=1)
        ).max()
        < 1e-3
    )
    assert (np.abs(mesh_with_tangents.tangents[:, 3]) == 1).all()
    for name in ("positions_m", "uvs"):
        assert np.array_equal(
            getattr(mesh_with_tangents, name)[mesh_with_tangents.triangles],
            getattr(mesh, name)[corners],
        )
