"""Compressed meshes and pictures of glTF files are those that were packed."""

import sys

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.framing import SceneTiming
from heatlens.media.scene.scene_read import read_scene
from support.compressed_files import RED_KTX2, UP, draco, packed, with_picture
from support.crashing import crashing
from support.gltf_files import SQUARE, SQUARE_CORNERS, SQUARE_UVS


def places(mesh):
    """Return every corner with its texture coordinates, in an order that packing cannot change."""
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
    with pytest.raises(InputError, match=r"a\.glb.*not a Draco mesh"):
        read_scene(draco(data).write(tmp_path / "a.glb"))


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


@pytest.mark.parametrize(
    ("name", "writer"),
    [
        ("DracoPy", draco),
        ("meshopt", packed),
        ("opengl_basisu", lambda: with_picture(RED_KTX2)),
    ],
)
def test_a_crash_of_a_library_is_a_sentence(tmp_path, monkeypatch, name, writer):
    monkeypatch.setenv("PYTHONPATH", str(crashing(tmp_path, name)))
    with pytest.raises(InputError, match=r"a\.glb .* crashes the library that reads it"):
        read_scene(writer().write(tmp_path / "a.glb"))


def test_frames_and_clips_are_those_that_were_chosen(tmp_path):
    """They cross over to the process that unpacks, as moving scenes come back from it."""
    path = draco().write(tmp_path / "a.glb")
    timing = SceneTiming(frames_per_second=48.0, first_frame=1001)
    assert read_scene(path, timing).frames_per_second == 48.0
    assert read_scene(path).frames_per_second != 48.0
