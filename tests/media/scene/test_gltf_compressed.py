"""Test that compressed meshes and images of glTF files unpack to what was packed."""

import sys

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.framing import SceneTiming
from heatlens.media.scene.scene_read import read_scene
from support.compressed_files import RED_KTX2, UP, draco_square, meshopt_square, square_with_ktx2
from support.crashing import write_crashing_library
from support.gltf_files import SQUARE, SQUARE_CORNERS, SQUARE_UVS


def sorted_corners(mesh):
    """Return every corner with its texture coordinates, in an order that packing cannot change."""
    rows = np.hstack([mesh.positions_m, mesh.uvs])[mesh.triangles].reshape(-1, 5)
    return np.array(sorted(np.round(rows, 3).tolist()))


@pytest.mark.parametrize("has_plain_data", [False, True])
def test_draco_mesh_unpacks_to_packed_mesh(tmp_path, has_plain_data):
    scene = read_scene(draco_square(None, has_plain_data).write(tmp_path / "a.glb"))
    rows = np.hstack([SQUARE, SQUARE_UVS])[SQUARE_CORNERS]
    np.testing.assert_allclose(sorted_corners(scene.meshes[0]), sorted(rows.tolist()), atol=2e-3)
    np.testing.assert_allclose(scene.meshes[0].normals, UP, atol=1e-2)
    assert not scene.notes


def test_draco_without_library_uses_plain_data_or_names_command(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "DracoPy", None)
    scene = read_scene(draco_square(None, has_plain_data=True).write(tmp_path / "a.glb"))
    np.testing.assert_array_equal(scene.meshes[0].positions_m, SQUARE)
    with pytest.raises(InputError, match=r"b\.glb.*DracoPy.*pip install 'heatlens\[scene\]'"):
        read_scene(draco_square().write(tmp_path / "b.glb"))


@pytest.mark.parametrize("data", [b"", b"DRACO\x02\x02", bytes(100)])
def test_draco_damage_is_reported_with_file_name(tmp_path, data):
    with pytest.raises(InputError, match=r"a\.glb.*not a Draco mesh"):
        read_scene(draco_square(data).write(tmp_path / "a.glb"))


@pytest.mark.parametrize("name", ["EXT_meshopt_compression", "KHR_meshopt_compression"])
def test_meshopt_buffer_unpacks_to_packed_mesh(tmp_path, name):
    writer = meshopt_square(name)
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
def test_meshopt_damage_is_reported_with_reason(tmp_path, changed, words):
    with pytest.raises(InputError, match=rf"a\.glb.*{words}"):
        read_scene(meshopt_square(**changed).write(tmp_path / "a.glb"))


def test_ktx2_image_has_its_pixels(tmp_path):
    scene = read_scene(square_with_ktx2(RED_KTX2).write(tmp_path / "a.glb"))
    np.testing.assert_array_equal(scene.images[0], np.tile([201, 0, 0, 255], (4, 4, 1)))


def test_ktx2_damage_drops_image_with_a_note(tmp_path):
    scene = read_scene(square_with_ktx2(RED_KTX2[:200]).write(tmp_path / "a.glb"))
    assert not scene.images and "picture is damaged" in scene.notes[0]


def test_ktx2_without_library_names_command(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "opengl_basisu", None)
    with pytest.raises(InputError, match=r"a\.glb.*opengl_basisu.*pip install"):
        read_scene(square_with_ktx2(RED_KTX2).write(tmp_path / "a.glb"))


@pytest.mark.parametrize(
    ("name", "writer"),
    [
        ("DracoPy", draco_square),
        ("meshopt", meshopt_square),
        ("opengl_basisu", lambda: square_with_ktx2(RED_KTX2)),
    ],
)
def test_crash_of_decoder_library_is_reported_in_one_sentence(tmp_path, monkeypatch, name, writer):
    monkeypatch.setenv("PYTHONPATH", str(write_crashing_library(tmp_path, name)))
    with pytest.raises(InputError, match=r"a\.glb .* crashes the library that reads it"):
        read_scene(writer().write(tmp_path / "a.glb"))


def test_compressed_scene_keeps_chosen_timing(tmp_path):
    """The timing is passed to the unpacking process, and moving scenes are passed back."""
    path = draco_square().write(tmp_path / "a.glb")
    timing = SceneTiming(frames_per_second=48.0, first_frame=1001)
    assert read_scene(path, timing).frames_per_second == 48.0
    assert read_scene(path).frames_per_second != 48.0
