"""Maps of normals in glTF files, and the tangents that go with them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from heatlens.core.base.errors import InputError
from heatlens.media.scene.mesh_make import made_mesh, with_tangents
from heatlens.media.scene.scene_read import read_scene
from support.gltf_files import SQUARE_UVS, GltfWriter
from support.scenes import plane, sphere

BUMPS = [[[200, 128, 240]]]
NORMALS = np.tile(np.float32([0, 0, 1]), (4, 1))
TOLD = np.tile(np.float32([0, 3, 0, -1]), (4, 1))


def bumpy(attributes=(), kind="PNG", look=(), **info) -> GltfWriter:
    """Return a square with a map of normals."""
    writer = GltfWriter()
    material = {"normalTexture": {"index": writer.picture(BUMPS, kind), **info}, **dict(look)}
    attributes = {"TEXCOORD_0": SQUARE_UVS, **dict(attributes)}
    number = writer.add("materials", **material)
    writer.node(mesh=writer.mesh(attributes=attributes, material=number))
    return writer


def read(writer, tmp_path):
    return read_scene(writer.write(tmp_path / "a.glb"))


def test_a_map_and_its_scale_are_read(tmp_path):
    scene = read(bumpy({"NORMAL": NORMALS}, scale=0.25), tmp_path)
    assert (scene.materials[0].normal_map, scene.materials[0].normal_scale) == (0, 0.25)
    assert scene.images[0][0, 0, :3].tolist() == BUMPS[0][0] and not scene.notes
    np.testing.assert_allclose(scene.meshes[0].tangents, [[1, 0, 0, 1]] * 4, atol=1e-6)
    assert read(bumpy(), tmp_path).materials[0].normal_scale == 1.0


@pytest.mark.parametrize("has_normals", [True, False])
def test_tangents_of_the_file_count_beside_its_normals_alone(tmp_path, has_normals):
    normals = {"NORMAL": NORMALS} if has_normals else {}
    tangents = read(bumpy({"TANGENT": TOLD, **normals}), tmp_path).meshes[0].tangents
    assert (tangents == ([0, 1, 0, -1] if has_normals else [1, 0, 0, 1])).all()


def test_a_mesh_without_such_a_map_has_no_tangents(tmp_path):
    writer = GltfWriter()
    attributes = {"NORMAL": NORMALS, "TANGENT": TOLD, "TEXCOORD_0": SQUARE_UVS}
    writer.node(mesh=writer.mesh(attributes=attributes))
    assert read(writer, tmp_path).meshes[0].tangents is None


@pytest.mark.parametrize(
    ("tangents", "said"),
    [
        (TOLD[:3], "3 of TANGENT"),
        (TOLD[:, :3].copy(), "VEC3"),
    ],
)
def test_tangents_that_cannot_be_are_refused(tmp_path, tangents, said):
    with pytest.raises(InputError, match=said):
        read(bumpy({"NORMAL": NORMALS, "TANGENT": tangents}), tmp_path)


@pytest.mark.parametrize(
    ("info", "said"), [({"index": 7}, "only 1 of them"), ({"scale": "steep"}, "a number")]
)
def test_a_map_that_cannot_be_is_refused(tmp_path, info, said):
    with pytest.raises(InputError, match=f"normalTexture.*{said}"):
        read(bumpy(**info), tmp_path)


def test_a_damaged_map_is_done_without(tmp_path):
    writer = bumpy()
    start = writer.data.index(b"PNG")
    writer.data[start : start + 40] = bytes(40)
    scene = read(writer, tmp_path)
    assert scene.materials[0].normal_map is None and "not a picture" in scene.notes[0]


@pytest.mark.parametrize("odd", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("name", ["NORMAL", "TANGENT", "TEXCOORD_0"])
def test_one_number_that_is_none_costs_no_scene(tmp_path, name, odd):
    attributes = {"NORMAL": NORMALS.copy(), "TANGENT": TOLD.copy(), "TEXCOORD_0": SQUARE_UVS.copy()}
    attributes[name][2, 0] = odd
    scene = read(bumpy(attributes), tmp_path)
    mesh = scene.meshes[0]
    for values in (mesh.normals, mesh.tangents, mesh.uvs):
        assert np.isfinite(values).all()
    np.testing.assert_allclose(mesh.normals, NORMALS, atol=1e-6)
    assert "are NaN" in scene.notes[0]


@pytest.mark.parametrize("scale", [1e300, -1e300])
def test_a_scale_beyond_reason_can_be_drawn(tmp_path, scale):
    found = read(bumpy(scale=scale), tmp_path).materials[0].normal_scale
    assert np.sign(found) == np.sign(scale) and abs(found) < 1e5


def test_a_map_that_lies_otherwise_than_the_colour_lies_where_it_says(tmp_path):
    look = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
    turned = {"TEXCOORD_1": SQUARE_UVS[:, ::-1].copy(), "NORMAL": NORMALS}
    scene = read(bumpy(turned, look=look, texCoord=1), tmp_path)
    material, mesh = scene.materials[0], scene.meshes[0]
    assert [place.coordinates for place in material.map_places] == [0, 0, 0, 1, 0]
    np.testing.assert_array_equal(mesh.uvs, SQUARE_UVS)
    np.testing.assert_array_equal(mesh.more_uvs, SQUARE_UVS[:, ::-1])
    np.testing.assert_allclose(mesh.tangents, [[0, -1, 0, -1]] * 4, atol=1e-6)
    look["occlusionTexture"] = {"index": 0, "strength": 0.75}
    scene = read(bumpy(look=look), tmp_path)
    material = scene.materials[0]
    assert (material.normal_map, material.occlusion_map, material.occlusion) == (0, 0, 0.75)


def test_a_map_alone_lies_where_it_says(tmp_path):
    uvs = {"TEXCOORD_1": SQUARE_UVS[:, ::-1].copy(), "NORMAL": NORMALS}
    scene = read(bumpy(uvs, texCoord=1), tmp_path)
    assert scene.materials[0].normal_map == 0 and not scene.notes
    # u runs down and v to the right: against v is to the left
    np.testing.assert_allclose(scene.meshes[0].tangents, [[0, -1, 0, -1]] * 4, atol=1e-6)


# Tangents out of uvs


def test_tangents_of_a_ball_run_along_its_circles():
    ball = sphere(1.0, 3)
    made = with_tangents(ball)
    inside = (np.abs(made.uvs[:, 0] - 0.5) < 0.3) & (np.abs(made.positions_m[:, 1]) < 0.8)
    along = np.cross([0, 1, 0], made.positions_m[inside])
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    assert (np.sum(along * made.tangents[inside, :3], axis=1) > 0.99).all()
    assert (made.tangents[inside, 3] == 1).all()


def test_two_halves_that_share_a_mirrored_picture_part_at_their_seam():
    """Half of a face is painted, and both sides of it show that."""
    positions = np.float32([[-1, 0, 0], [0, 0, 0], [1, 0, 0], [-1, 1, 0], [0, 1, 0], [1, 1, 0]])
    uvs = np.float32([[1, 1], [0, 1], [1, 1], [1, 0], [0, 0], [1, 0]])
    corners = np.uint32([[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]])
    normals = np.tile(np.float32([0, 0, 1]), (6, 1))
    made = with_tangents(made_mesh("face", positions, corners, normals, uvs))
    assert len(made.positions_m) == 8
    assert np.array_equal(made.positions_m[made.triangles], positions[corners])
    found = made.tangents[made.triangles]
    np.testing.assert_allclose(found[:2], np.tile([-1, 0, 0, -1], (2, 3, 1)), atol=1e-6)
    np.testing.assert_allclose(found[2:], np.tile([1, 0, 0, 1], (2, 3, 1)), atol=1e-6)


def test_corners_that_run_the_other_way_round_change_nothing():
    sheet = plane()
    turned = made_mesh("a", sheet.positions_m, sheet.triangles[:, ::-1], sheet.normals, sheet.uvs)
    np.testing.assert_allclose(with_tangents(turned).tangents, with_tangents(sheet).tangents)


NUMBERS = st.floats(-1e3, 1e3, width=32)


@given(
    hnp.arrays(np.float32, (5, 3), elements=NUMBERS),
    hnp.arrays(np.float32, (5, 2), elements=NUMBERS),
    hnp.arrays(np.uint32, (4, 3), elements=st.integers(0, 4)),
)
def test_whatever_a_mesh_is_its_tangents_are_unit_and_upright_or_nothing(positions, uvs, corners):
    normals = np.tile(np.float32([0.6, 0, 0.8]), (5, 1))
    mesh = made_mesh("a", positions, corners, normals, uvs)
    made = with_tangents(mesh)
    lengths = np.linalg.norm(made.tangents[:, :3], axis=1)
    assert ((np.abs(lengths - 1) < 1e-4) | (lengths == 0)).all()
    assert np.abs(np.sum(made.tangents[:, :3] * made.normals, axis=1)).max() < 1e-3
    assert (np.abs(made.tangents[:, 3]) == 1).all()
    for name in ("positions_m", "uvs"):
        assert np.array_equal(getattr(made, name)[made.triangles], getattr(mesh, name)[corners])
