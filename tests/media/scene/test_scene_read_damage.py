"""Damaged glTF files: each is a scene still, or one sentence with the file's name."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.media.scene.scene_read import read_scene
from support.gltf_files import SQUARE, SQUARE_CORNERS, SQUARE_UVS, GltfWriter, square_scene


@pytest.fixture
def path(tmp_path):
    return tmp_path / "scene.glb"


def error_message_of(path, data=None):
    """Return the error message of `read_scene` for a file with these bytes."""
    if data is not None:
        path.write_bytes(data)
    with pytest.raises(InputError) as caught:
        read_scene(path)
    assert path.name in str(caught.value)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def rich_scene():
    """Return a glTF writer with one of everything that `read_scene` reads."""
    writer = GltfWriter()
    writer.picture(np.zeros((2, 2, 3)))
    shine = {"baseColorTexture": {"index": 0}, "roughnessFactor": 0.5}
    material = writer.add("materials", pbrMetallicRoughness=shine, alphaMode="MASK")
    mesh = writer.mesh(attributes={"TEXCOORD_0": SQUARE_UVS}, material=material)
    camera = writer.add("cameras", type="perspective", perspective={"yfov": 0.5, "znear": 1})
    leaf = writer.node(is_root=False, mesh=mesh, translation=[1, 2, 3])
    writer.node(children=[leaf], rotation=[0, 0, 0, 1])
    eye = writer.node(camera=camera)
    writer.node(**writer.light(type="spot", spot={"outerConeAngle": 0.5}))
    writer.animate(eye, "translation", [0, 0.25], [[0, 0, 5], [0, 0, 29]])
    writer.animate(leaf, "rotation", [0, 0.25], [[0, 0, 0, 1], [0, 1, 0, 0]])
    return writer


RICH = rich_scene().glb()


def check_survives(path, data):
    """Check that `read_scene` gives a usable scene or an error that names the file."""
    path.write_bytes(data)
    try:
        scene = read_scene(path)
    except HeatlensError as error:
        assert path.name in str(error)
        return
    for frame in (1, 3.5):
        assert np.isfinite(scene.transforms_at(frame)).all()
    for mesh in scene.meshes:
        assert mesh.triangles.max() < len(mesh.positions_m) == len(mesh.normals) == len(mesh.uvs)
        assert np.isfinite(np.hstack([mesh.positions_m, mesh.normals, mesh.uvs])).all()


@pytest.fixture(scope="module")
def fuzzed(tmp_path_factory):
    return tmp_path_factory.mktemp("fuzz") / "scene.glb"


def test_rich_gltf_has_everything_before_damage(fuzzed):
    fuzzed.write_bytes(RICH)
    scene = read_scene(fuzzed)
    assert (len(scene.cameras), len(scene.lights), len(scene.images)) == (1, 1, 1)
    assert scene.motion is not None


@given(st.integers(0, len(RICH) - 1))
@settings(deadline=None)
def test_read_scene_rejects_gltf_truncated_at_any_byte(fuzzed, length):
    assert error_message_of(fuzzed, RICH[:length])


@given(
    st.lists(st.tuples(st.integers(0, len(RICH) - 1), st.integers(1, 255)), min_size=1, max_size=4)
)
@settings(deadline=None, max_examples=400)
def test_read_scene_survives_changed_bytes(fuzzed, flips):
    data = bytearray(RICH)
    for at, change in flips:
        data[at] ^= change
    check_survives(fuzzed, bytes(data))


def key_paths_in(value, found=()):
    """Return the path of keys and indices to every entry of a JSON value."""
    yield found
    steps = enumerate(value) if isinstance(value, list) else ()
    for key, inner in value.items() if isinstance(value, dict) else steps:
        yield from key_paths_in(inner, (*found, key))


PLACES = [place for place in key_paths_in(rich_scene().json) if place]
ODD = [None, True, -1, 0, 1, 3, 0.5, 1e30, 1e308, 2**31, 2**63, "", "x", [], [0], {}, [[]], [None]]


@given(st.sampled_from(PLACES), st.sampled_from(ODD))
@settings(deadline=None, max_examples=600)
def test_read_scene_survives_json_entry_of_wrong_type(fuzzed, place, odd):
    writer = rich_scene()
    inner = writer.json
    for step in place[:-1]:
        inner = inner[step]
    inner[place[-1]] = odd
    check_survives(fuzzed, writer.glb())


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "empty"),
        (b"glTF", "cut short"),
        (b"\xff\xd8\xff\xe0 a photograph", "damaged or not glTF"),
        (b"{}", "not glTF version 2"),
        (b"[]", "object in braces"),
        (b'{"asset": {"version": "2.0"}}', "no surfaces to look at"),
        (b'{"asset": {"version": "1.0"}}', "'1.0'"),
        (b"[" * 100_000, "damaged or not glTF"),
        (b"glTF\x01\0\0\0" + bytes(20), "version 1"),
    ],
)
def test_read_scene_rejects_file_that_is_no_scene(path, data, words):
    assert words in error_message_of(path, data)


def test_read_scene_reports_missing_file_and_folder(path, tmp_path):
    assert "is not there" in error_message_of(path)
    path.mkdir()
    assert "is a folder" in error_message_of(path)
    assert "reads .glb" in error_message_of(tmp_path / "scene.docx")


@pytest.mark.parametrize(
    "uri", ["http://example.org/a.bin", "https://example.org/a.bin", "file:///etc/passwd", "//x/y"]
)
def test_gltf_bytes_from_network_are_not_fetched(path, uri):
    assert "not a local file" in error_message_of(path, square_scene().gltf(uri))


@pytest.mark.parametrize("uri", ["../out.bin", "%2e%2e/out.bin", "sub/../../out.bin"])
def test_gltf_bytes_outside_folder_are_not_read(tmp_path, uri):
    writer = square_scene()
    (tmp_path / "out.bin").write_bytes(writer.data)
    (tmp_path / "in").mkdir()
    assert "out of the folder" in error_message_of(tmp_path / "in" / "scene.gltf", writer.gltf(uri))


def test_gltf_bytes_behind_link_out_of_folder_are_not_read(tmp_path):
    writer = square_scene()
    (tmp_path / "out.bin").write_bytes(writer.data)
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "a.bin").symlink_to(tmp_path / "out.bin")
    assert "out of the folder" in error_message_of(
        tmp_path / "in" / "scene.gltf", writer.gltf("a.bin")
    )


def test_gltf_missing_or_short_buffer_is_reported(path):
    assert "cannot be read" in error_message_of(path, square_scene().gltf("gone.bin"))
    (path.parent / "short.bin").write_bytes(b"1234")
    assert "cut short" in error_message_of(path, square_scene().gltf("short.bin"))
    assert "base64" in error_message_of(path, square_scene().gltf("data:;base64,@@@@"))


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e30])
def test_gltf_non_finite_vertices_are_rejected(path, value):
    positions = SQUARE.copy()
    positions[2, 1] = value
    writer = GltfWriter()
    writer.node(mesh=writer.mesh(positions))
    error_message_of(path, writer.glb())


def test_gltf_triangles_of_missing_vertices_are_rejected(path):
    writer = GltfWriter()
    writer.node(mesh=writer.mesh(corners=SQUARE_CORNERS + np.uint16(1)))
    assert "beyond the 4 vertices" in error_message_of(path, writer.glb())


def glb_with_changed_entries(name, **entries):
    """Return the rich scene as GLB with changed entries in the first item of the list `name`.

    An entry of None is deleted.
    """
    writer = rich_scene()
    writer.json[name][0] |= entries
    for entry in (entry for entry, value in entries.items() if value is None):
        del writer.json[name][0][entry]
    return writer.glb()


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (glb_with_changed_entries("accessors", count=2**40), "reach past"),
        (glb_with_changed_entries("accessors", byteOffset=2**50), "reach past"),
        (glb_with_changed_entries("accessors", componentType=1), "not a number type"),
        (glb_with_changed_entries("nodes", children=[1]), "two parents"),
        (glb_with_changed_entries("nodes", scale=[1e30, 1, 1]), "which is too much"),
        (glb_with_changed_entries("nodes", translation=[1e305, 0, 0]), "out of range"),
        (glb_with_changed_entries("materials", alphaMode="FOG"), "not an alpha mode"),
    ],
)
def test_gltf_damage_is_reported_with_its_cause(path, data, words):
    assert words in error_message_of(path, data)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (glb_with_changed_entries("bufferViews", byteLength=2**40), "ends at byte"),
        (glb_with_changed_entries("bufferViews", buffer=1), "only 1 of them"),
        (glb_with_changed_entries("images", bufferView=1), "not a picture"),
        (glb_with_changed_entries("images", bufferView="1"), "should be a number"),
        (
            glb_with_changed_entries("images", uri="gone.png", bufferView=None),
            "'gone.png' cannot be read",
        ),
        (
            glb_with_changed_entries("images", uri="../gone.png", bufferView=None),
            "leads out of the folder",
        ),
        (glb_with_changed_entries("textures", source=None), "no picture of a known kind"),
    ],
)
def test_gltf_unreadable_image_is_left_out_with_a_note(path, data, words):
    path.write_bytes(data)
    scene = read_scene(path)
    assert len(scene.instances) == 1 and not scene.images
    assert scene.materials[0].base_color_map is None
    (note,) = scene.notes
    assert words in note and "1 picture is left out" in note


def test_gltf_accessor_without_bytes_allocates_no_memory(path):
    writer = rich_scene()
    record = writer.json["accessors"][0]
    del record["bufferView"]
    record["count"] = 2**40
    assert "has no bytes" in error_message_of(path, writer.glb())


def test_gltf_too_large_image_is_left_out(path):
    import struct
    import zlib

    head = b"IHDR" + struct.pack(">IIBBBBB", 2**20, 2**20, 8, 6, 0, 0, 0)
    chunk = struct.pack(">I", 13) + head + struct.pack(">I", zlib.crc32(head))
    writer = rich_scene()
    writer.json["images"][0]["bufferView"] = writer.view(b"\x89PNG\r\n\x1a\n" + chunk)
    scene = read_scene(writer.write(path))
    assert not scene.images and "left out" in scene.notes[0]
