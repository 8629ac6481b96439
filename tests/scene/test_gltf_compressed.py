"""Compressed meshes and pictures of glTF files are those that were packed."""

import base64
import sys

import DracoPy
import meshopt
import numpy as np
import pytest

from heatlens.errors import InputError
from heatlens.scene.scene_read import read_scene
from support.gltf_files import SQUARE, SQUARE_CORNERS, SQUARE_UVS, GltfWriter

DRACO = "KHR_draco_mesh_compression"
UP = np.tile([0.0, 0.0, 1.0], (4, 1))
# 4 x 4 pixels of (201, 0, 0, 255), in the KTX 2 that Basis Universal 2.1 writes.
RED_KTX2 = base64.b64decode(
    "q0tUWCAyMLsNChoKAAAAAAEAAAAEAAAABAAAAAAAAAAAAAAAAQAAAAEAAAABAAAAaAAAACwAAACUAAAAJAAAALgAAAAA"
    "AAAAgQAAAAAAAAA5AQAAAAAAAAEAAAAAAAAAAAAAAAAAAAAsAAAAAAAAAAIAKACjAQIAAwMAAAgAAAAAAAAAAAA/AAAA"
    "AAAAAAAA/////x8AAABLVFh3cml0ZXIAQmFzaXMgVW5pdmVyc2FsIDIuMTAAAAEAAQApAAAABQAAACsAAAAAAAAAAAAA"
    "AAAAAAABAAAAAAAAAAAAAAABwAQAAAAAAAAiApgBAAAAAABA2gkAJgAAAAAAABACwASAAAAAAAAiBqyqqqoCAMFEAAAA"
    "AAAA8l8tAJgAAAAAAABACAATAAIAAAAAiAHABAAAAAAAAAIIAAA="
)


def draco(data=None, has_plain_data=False):
    """Return a square packed by Draco."""
    packed = DracoPy.encode(
        SQUARE.astype(float),
        faces=SQUARE_CORNERS.reshape(-1, 3).astype(np.uint32),
        tex_coord=SQUARE_UVS.astype(float),
        normals=UP,
        quantization_bits=14,
    )
    numbers = {
        name: part["unique_id"]
        for part in DracoPy.decode(packed).attributes
        for kind, name in ((0, "POSITION"), (1, "NORMAL"), (3, "TEXCOORD_0"))
        if part["attribute_type"] == kind
    }
    writer = GltfWriter()
    named = {"NORMAL": UP.astype(np.float32), "TEXCOORD_0": SQUARE_UVS}
    mesh = writer.mesh(SQUARE, SQUARE_CORNERS, named)
    if not has_plain_data:
        for accessor in writer.json["accessors"]:
            del accessor["bufferView"]
    told = {"bufferView": writer.view(packed if data is None else data), "attributes": numbers}
    writer.json["meshes"][mesh]["primitives"][0]["extensions"] = {DRACO: told}
    writer.json["extensionsUsed"] = [DRACO]
    writer.node(mesh=mesh)
    return writer


def places(mesh):
    """Every corner with its texture coordinates, in an order that packing cannot change."""
    rows = np.hstack([mesh.positions_m, mesh.uvs])[mesh.triangles].reshape(-1, 5)
    return np.array(sorted(np.round(rows, 3).tolist()))


@pytest.mark.parametrize("has_plain_data", [False, True])
def test_a_mesh_of_draco_is_what_was_packed(tmp_path, has_plain_data):
    scene = read_scene(draco(None, has_plain_data).write(tmp_path / "a.glb"))
    rows = np.hstack([SQUARE, SQUARE_UVS])[SQUARE_CORNERS]
    np.testing.assert_allclose(places(scene.meshes[0]), sorted(rows.tolist()), atol=2e-3)
    np.testing.assert_allclose(scene.meshes[0].normals, UP, atol=1e-2)
    assert not scene.notes


def test_without_its_library_plain_data_are_read_or_the_command_is_told(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "DracoPy", None)
    scene = read_scene(draco(None, True).write(tmp_path / "a.glb"))
    np.testing.assert_array_equal(scene.meshes[0].positions_m, SQUARE)
    with pytest.raises(InputError, match=r"b\.glb.*DracoPy.*pip install 'heatlens\[scene\]'"):
        read_scene(draco().write(tmp_path / "b.glb"))


@pytest.mark.parametrize("data", [b"", b"DRACO\x02\x02", bytes(100)])
def test_damaged_bytes_of_draco_are_named(tmp_path, data):
    with pytest.raises(InputError, match=r"a\.glb.*no mesh of Draco"):
        read_scene(draco(data).write(tmp_path / "a.glb"))


def packed(name="EXT_meshopt_compression", **changed):
    """Return a square whose views are packed by meshoptimizer."""
    writer = GltfWriter()
    mesh = writer.mesh()
    writer.more_buffers.append({"byteLength": 1000})
    for view, values, mode in ((0, SQUARE, "ATTRIBUTES"), (1, SQUARE_CORNERS, "TRIANGLES")):
        data = meshopt.encode_gltf_buffer(values, mode)
        told = {"buffer": 0, "byteOffset": len(writer.data), "byteLength": len(data)}
        told |= {"mode": mode, "count": len(values), "byteStride": values[0].nbytes}
        writer.data += data + bytes(-len(data) % 4)
        record = writer.json["bufferViews"][view]
        record["extensions"] = {name: told | changed}
        record["buffer"] = 1
    writer.node(mesh=mesh)
    return writer


@pytest.mark.parametrize("name", ["EXT_meshopt_compression", "KHR_meshopt_compression"])
def test_a_buffer_of_meshoptimizer_is_what_was_packed(tmp_path, name):
    writer = packed(name)
    writer.json["extensionsRequired"] = [name]
    mesh = read_scene(writer.write(tmp_path / "a.glb")).meshes[0]
    np.testing.assert_array_equal(
        mesh.positions_m[mesh.triangles], SQUARE[SQUARE_CORNERS].reshape(2, 3, 3)
    )


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"mode": "WAVES"}, "mode must be"),
        ({"byteStride": 13}, "unpacked"),
        ({"count": 2**40}, "too much"),
        ({"byteLength": 3}, "unpacked"),
    ],
)
def test_a_buffer_that_cannot_be_unpacked_is_named(tmp_path, changed, words):
    with pytest.raises(InputError, match=rf"a\.glb.*{words}"):
        read_scene(packed(**changed).write(tmp_path / "a.glb"))


def with_picture(data):
    writer = GltfWriter()
    image = writer.add("images", bufferView=writer.view(data), mimeType="image/ktx2")
    basis = {"KHR_texture_basisu": {"source": image}}
    info = {"index": writer.add("textures", extensions=basis)}
    material = writer.add("materials", pbrMetallicRoughness={"baseColorTexture": info})
    writer.node(mesh=writer.mesh(attributes={"TEXCOORD_0": SQUARE_UVS}, material=material))
    return writer


def test_a_picture_in_ktx2_has_its_pixels(tmp_path):
    scene = read_scene(with_picture(RED_KTX2).write(tmp_path / "a.glb"))
    np.testing.assert_array_equal(scene.images[0], np.tile([201, 0, 0, 255], (4, 4, 1)))


def test_a_damaged_picture_in_ktx2_is_done_without(tmp_path):
    scene = read_scene(with_picture(RED_KTX2[:200]).write(tmp_path / "a.glb"))
    assert not scene.images and "picture is damaged" in scene.notes[0]


def test_a_picture_in_ktx2_tells_which_command_is_needed(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "opengl_basisu", None)
    with pytest.raises(InputError, match=r"a\.glb.*opengl_basisu.*pip install"):
        read_scene(with_picture(RED_KTX2).write(tmp_path / "a.glb"))
