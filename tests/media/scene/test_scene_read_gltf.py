"""glTF geometry and materials, against the numbers that were written."""

import numpy as np
import pytest
from PIL import Image

from heatlens.media.scene.scene_bounds import bounds_m
from heatlens.media.scene.scene_read import is_scene_file, read_scene
from support.gltf_files import SQUARE, SQUARE_CORNERS, SQUARE_UVS, GltfWriter, encoded, square_scene

CHECKERS = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [9, 8, 7]]], np.uint8)
UP_Z = np.tile([0, 0, 1], (4, 1)).astype(np.float32)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "scene.glb"


def corners_of(mesh):
    """Return the corners (T, 3, 3) of the triangles."""
    return mesh.positions_m[mesh.triangles]


def test_is_scene_file_recognizes_suffix():
    assert all(is_scene_file(name) for name in ("a.glb", "dir/B.GLTF"))
    assert not any(is_scene_file(name) for name in ("a.exr", "glb", "a.glb.txt", ""))


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.uint32])
def test_gltf_indices_of_every_width_give_same_triangles(path, kind):
    writer = GltfWriter()
    writer.node(mesh=writer.mesh(corners=SQUARE_CORNERS.astype(kind)))
    mesh = read_scene(writer.write(path)).meshes[0]
    assert np.array_equal(corners_of(mesh), SQUARE[SQUARE_CORNERS].reshape(2, 3, 3))


def test_gltf_vertices_without_indices_form_triangles_in_order(path):
    writer = GltfWriter()
    writer.node(mesh=writer.mesh(SQUARE[SQUARE_CORNERS], None))
    mesh = read_scene(writer.write(path)).meshes[0]
    assert np.array_equal(corners_of(mesh), SQUARE[SQUARE_CORNERS].reshape(2, 3, 3))


@pytest.mark.parametrize(
    ("mode", "order"), [(5, [0, 1, 3, 2]), (6, [0, 1, 2, 3])], ids=["strip", "fan"]
)
def test_gltf_strips_and_fans_cover_square_and_face_one_way(path, mode, order):
    writer = GltfWriter()
    writer.node(mesh=writer.mesh(SQUARE[order], None, mode=mode))
    mesh = read_scene(writer.write(path)).meshes[0]
    a, b, c = corners_of(mesh).swapaxes(0, 1)
    areas = np.cross(b - a, c - a)[:, 2] / 2
    assert areas == pytest.approx([0.5, 0.5])


def test_gltf_missing_normals_are_those_of_each_triangle(path):
    roof = np.array([[0, 0, 0], [2, 0, 0], [2, 0, -2], [0, 0, -2], [0, 2, -2]], np.float32)
    writer = GltfWriter()
    writer.node(mesh=writer.mesh(roof, np.array([0, 1, 2, 0, 3, 4], np.uint16)))
    mesh = read_scene(writer.write(path)).meshes[0]
    normals = mesh.normals[mesh.triangles]
    assert normals[0] == pytest.approx(np.tile([0, 1, 0], (3, 1)))
    assert np.abs(normals[1]) == pytest.approx(np.tile([1, 0, 0], (3, 1)))


def test_gltf_normals_of_file_are_normalized(path):
    writer = GltfWriter()
    writer.node(mesh=writer.mesh(attributes={"NORMAL": 3 * UP_Z[:, [2, 1, 0]]}))
    mesh = read_scene(writer.write(path)).meshes[0]
    assert mesh.normals == pytest.approx(np.tile([1, 0, 0], (4, 1)))


def test_gltf_interleaved_attributes_are_separated(path):
    rows = np.concatenate([SQUARE, UP_Z, SQUARE_UVS], axis=1).astype(np.float32)
    writer = GltfWriter()
    view = writer.view(rows.tobytes(), byteStride=32)
    attributes = {
        name: writer.add(
            "accessors", bufferView=view, byteOffset=at, componentType=5126, count=4, type=kind
        )
        for name, at, kind in (
            ("POSITION", 0, "VEC3"),
            ("NORMAL", 12, "VEC3"),
            ("TEXCOORD_0", 24, "VEC2"),
        )
    }
    primitive = {"attributes": attributes, "indices": writer.accessor(SQUARE_CORNERS)}
    writer.node(mesh=writer.add("meshes", primitives=[primitive]))
    mesh = read_scene(writer.write(path)).meshes[0]
    assert np.array_equal(mesh.positions_m, SQUARE)
    assert np.array_equal(mesh.normals, UP_Z)
    assert np.array_equal(mesh.uvs, SQUARE_UVS)


def test_gltf_sparse_accessor_replaces_some_vertices(path):
    writer = square_scene()
    record = writer.json["accessors"][0]
    record["sparse"] = {
        "count": 1,
        "indices": {"bufferView": writer.view(np.uint8([2]).tobytes()), "componentType": 5121},
        "values": {"bufferView": writer.view(np.float32([5, 6, 7]).tobytes())},
    }
    scene = read_scene(writer.write(path))
    assert bounds_m(scene, 1)[1] == pytest.approx([5, 6, 7])


def test_gltf_normalized_integers_are_fractions(path):
    writer = GltfWriter()
    uvs = (SQUARE_UVS * 255).astype(np.uint8)
    mesh = writer.mesh(attributes={"NORMAL": UP_Z, "TEXCOORD_0": np.pad(uvs, ((0, 0), (0, 2)))})
    record = writer.json["accessors"][1]
    record |= {"type": "VEC2", "normalized": True}
    writer.json["bufferViews"][1]["byteStride"] = 4
    writer.node(mesh=mesh)
    assert np.array_equal(read_scene(writer.write(path)).meshes[0].uvs, SQUARE_UVS)


def test_gltf_mesh_is_placed_by_each_of_its_nodes(path):
    writer = GltfWriter()
    mesh = writer.mesh()
    leaf = writer.node(is_root=False, mesh=mesh, translation=[1, 0, 0])
    half = np.sqrt(0.5)
    writer.node(rotation=[0, half, 0, half], scale=[2, 2, 2], children=[leaf])
    writer.node(mesh=mesh, name="moved", matrix=[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1])
    scene = read_scene(writer.write(path))
    assert (len(scene.meshes), len(scene.instances), scene.triangle_count) == (1, 2, 4)
    first, second = scene.transforms_at(1) @ [1, 0, 0, 1]
    assert first == pytest.approx([0, 0, -4, 1])  # a quarter turn about y takes +x to -z
    assert second == pytest.approx([8, 8, 9, 1])
    assert scene.instances[1].name == "moved"


def test_gltf_gpu_instancing_places_mesh_at_each_position(path):
    writer = GltfWriter()
    places = writer.accessor(np.array([[1, 0, 0], [2, 0, 0], [3, 0, 0]], np.float32))
    spread = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}}
    writer.node(mesh=writer.mesh(), extensions=spread, translation=[0, 5, 0])
    scene = read_scene(writer.write(path))
    found = np.stack([instance.to_world[:3, 3] for instance in scene.instances])
    assert found.tolist() == [[1, 5, 0], [2, 5, 0], [3, 5, 0]]


def textured_square(**material):
    """Return a square with a material, and one texture of four colours."""
    writer = GltfWriter()
    writer.picture(CHECKERS)
    number = writer.add("materials", **material)
    writer.node(mesh=writer.mesh(attributes={"TEXCOORD_0": SQUARE_UVS}, material=number))
    return writer


def test_gltf_material_has_all_factors_and_maps(path):
    writer = textured_square(
        name="lamp",
        pbrMetallicRoughness={
            "baseColorFactor": [0.1, 0.2, 0.3, 0.9],
            "metallicFactor": 0.25,
            "roughnessFactor": 0.75,
            "baseColorTexture": {"index": 0},
            "metallicRoughnessTexture": {"index": 0},
        },
        emissiveFactor=[1, 0.5, 0],
        emissiveTexture={"index": 0},
        extensions={"KHR_materials_emissive_strength": {"emissiveStrength": 40}},
        alphaMode="MASK",
        alphaCutoff=0.3,
    )
    scene = read_scene(writer.write(path))
    material = scene.materials[scene.meshes[0].material]
    assert (material.name, material.base_color) == ("lamp", (0.1, 0.2, 0.3))
    assert (material.metallic, material.roughness) == (0.25, 0.75)
    assert (material.emission, material.alpha_cutoff) == ((40, 20, 0), 0.3)
    maps = material.base_color_map, material.metallic_roughness_map, material.emission_map
    assert (maps, len(scene.images)) == ((0, 0, 0), 1)
    assert np.array_equal(scene.images[0][..., :3], CHECKERS)
    assert (scene.images[0][..., 3] == 255).all()
    assert np.array_equal(scene.meshes[0].uvs[scene.meshes[0].triangles[0, 0]], SQUARE_UVS[0])


def test_gltf_mesh_without_material_has_default_material(path):
    scene = read_scene(square_scene().write(path))
    material = scene.materials[scene.meshes[0].material]
    assert (material.base_color, material.metallic, material.roughness) == ((1, 1, 1), 1, 1)


@pytest.mark.parametrize(
    ("mode", "expected"),
    [("OPAQUE", (1, 0, False)), ("MASK", (0.4, 0.5, False)), ("BLEND", (0.4, 0, True))],
)
def test_gltf_alpha_depends_on_alpha_mode(path, mode, expected):
    shine = {"baseColorFactor": [1, 1, 1, 0.4]}
    scene = read_scene(textured_square(pbrMetallicRoughness=shine, alphaMode=mode).write(path))
    material = scene.materials[0]
    assert (material.base_alpha, material.alpha_cutoff, material.is_blended) == expected
    assert not scene.notes


def test_gltf_texture_transform_rotates_and_moves_uvs(path):
    """The example of KHR_texture_transform: the lower left quarter, a quarter turn clockwise."""
    moved = {"offset": [0, 1], "rotation": np.pi / 2, "scale": [0.5, 0.5]}
    info = {"index": 0, "extensions": {"KHR_texture_transform": moved}}
    scene = read_scene(textured_square(pbrMetallicRoughness={"baseColorTexture": info}).write(path))
    uvs = scene.meshes[0].uvs
    assert uvs.min(axis=0) == pytest.approx([0, 0.5], abs=1e-6)
    assert uvs.max(axis=0) == pytest.approx([0.5, 1], abs=1e-6)


def test_gltf_reads_bytes_and_images_beside_the_file(tmp_path):
    writer = textured_square(pbrMetallicRoughness={"baseColorTexture": {"index": 0}})
    writer.json["images"] = [{"uri": "a%20map.png"}]
    (tmp_path / "a map.png").write_bytes(encoded(CHECKERS))
    (tmp_path / "scene.bin").write_bytes(writer.data)
    path = tmp_path / "scene.gltf"
    path.write_bytes(writer.gltf("scene.bin"))
    scene = read_scene(path)
    assert np.array_equal(scene.images[0][..., :3], CHECKERS)


def test_gltf_reads_bytes_embedded_in_json(tmp_path):
    scene = read_scene(square_scene().write(tmp_path / "scene.gltf"))
    assert scene.triangle_count == 2


@pytest.mark.parametrize("depth", [8, 16])
def test_gltf_gray_images_keep_their_brightness(depth, path):
    grey = np.array([[0, 128], [200, 255]], np.uint32)
    pixels = (grey * 257).astype(np.uint16) if depth == 16 else grey.astype(np.uint8)
    writer = textured_square(pbrMetallicRoughness={"baseColorTexture": {"index": 0}})
    file = path.with_suffix(".png")
    Image.fromarray(pixels).save(file)
    writer.json["images"][0] = {"bufferView": writer.view(file.read_bytes())}
    scene = read_scene(writer.write(path))
    assert np.array_equal(scene.images[0][..., 0], grey)
