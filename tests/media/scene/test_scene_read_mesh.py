"""OBJ, PLY and STL files, written by hand; damage ends in a sentence."""

import struct
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.media.scene.scene_bounds import bounds_m
from heatlens.media.scene.scene_read import read_scene
from support.command_line import start_heatlens
from support.gltf_files import encoded
from support.mesh_files import MTL, OBJ, PIXELS, PLY, STL
from support.patience import PATIENCE_S


def test_obj_is_read_with_materials_and_map(tmp_path):
    (tmp_path / "a.obj").write_text(OBJ)
    (tmp_path / "a.mtl").write_text(MTL)
    (tmp_path / "pic.png").write_bytes(encoded(PIXELS))
    scene = read_scene(tmp_path / "a.obj")
    meshes = {scene.materials[mesh.material].name: mesh for mesh in scene.meshes}
    red, blue = (scene.materials[meshes[name].material] for name in ("red", "blue"))
    assert np.array_equal(scene.images[red.base_color_map][..., :3], PIXELS)
    assert (blue.base_color, blue.emission, blue.base_alpha) == ((0, 0.5, 1), (3, 2, 1), 0.25)
    assert red.roughness < blue.roughness == 1
    mesh = meshes["red"]
    uvs = mesh.uvs[mesh.triangles[0]]
    assert uvs.tolist() == [[0, 1], [1, 1], [1, 0]]  # v runs down here
    assert mesh.normals[mesh.triangles[0]] == pytest.approx(np.tile([0, 0, 1], (3, 1)))
    assert bounds_m(scene, 1).tolist() == [[0, 0, 0], [2, 3, 0]]


def test_obj_with_missing_or_outside_materials_is_read_without(tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "a.mtl").write_text(MTL)
    for name in ("gone.mtl", "../a.mtl"):
        (tmp_path / "in" / "a.obj").write_text(OBJ.replace("a.mtl", name))
        scene = read_scene(tmp_path / "in" / "a.obj")
        assert scene.triangle_count == 2
        assert f"{name} is missing" in scene.notes[0]


def test_ply_vertex_colors_are_read(tmp_path):
    (tmp_path / "a.ply").write_bytes(PLY)
    scene = read_scene(tmp_path / "a.ply")
    assert bounds_m(scene, 1).tolist() == [[0, 0, 5], [1, 1, 5]]
    assert scene.materials[0].base_color == (1, 1, 1) and not scene.notes
    assert scene.meshes[0].colors == pytest.approx(np.tile([1, 0, 1], (4, 1)))
    assert scene.meshes[0].normals == pytest.approx(np.tile([0, 0, 1], (4, 1)))


CURVE = {0: 0.0, 55: 0.038204, 128: 0.215861, 188: 0.502886, 255: 1.0}  # of IEC 61966-2-1
SHADES = np.array([(0, 55, 255), (128, 188, 0), (255, 255, 255)])
LIGHTS = np.vectorize(CURVE.get)(SHADES)


def shaded_ply(is_face):
    """Return a PLY of three triangles with a color for each face, or for each vertex."""
    places = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (0, 2, 0)]
    corners = [(0, 1, 2), (2, 1, 3), (2, 3, 4)]
    tint = [f"property uchar {name}" for name in ("red", "green", "blue")]
    shades = [" ".join(map(str, shade)) for shade in [*SHADES, SHADES[0], SHADES[1]]]
    vertices, faces = ([" ".join(map(str, row)) for row in rows] for rows in (places, corners))
    faces = ["3 " + row for row in faces]
    rows = faces if is_face else vertices
    rows[:] = [f"{row} {shade}" for row, shade in zip(rows, shades, strict=False)]
    head = ["ply", "format ascii 1.0", "element vertex 5"]
    head += [f"property float {axis}" for axis in "xyz"] + tint * (not is_face)
    head += ["element face 3", "property list uchar int vertex_indices"] + tint * is_face
    return "\n".join([*head, "end_header", *vertices, *faces, ""])


@pytest.mark.parametrize("is_face", [False, True])
def test_ply_colors_of_vertices_and_faces_become_linear_light(tmp_path, is_face):
    (tmp_path / "a.ply").write_text(shaded_ply(is_face))
    mesh = read_scene(tmp_path / "a.ply").meshes[0]
    found = mesh.colors[mesh.triangles]
    expected = LIGHTS[:, None].repeat(3, axis=1) if is_face else LIGHTS[None]
    np.testing.assert_allclose(found[: len(expected)], expected, atol=1e-5)
    assert mesh.normals == pytest.approx(np.tile([0, 0, 1], (len(mesh.normals), 1)))


@pytest.mark.parametrize("extra", ["", "usemtl red\n", "vt 0 0\n"])
def test_obj_vertex_colors_are_read_after_positions(tmp_path, extra):
    """Vertex colors replace the color of a material that has no texture."""
    shades = [" ".join(f"{value / 255:.6f}" for value in shade) for shade in SHADES]
    vertices = [f"v {i % 2} {i // 2} 0 {shade}\n" for i, shade in enumerate(shades)]
    corner = "{0}/1" if "vt" in extra else "{0}"
    face = "f " + " ".join(corner.format(i) for i in (1, 2, 3))
    (tmp_path / "a.mtl").write_text("newmtl red\nKd 1 0 0\n")
    (tmp_path / "a.obj").write_text("mtllib a.mtl\n" + "".join(vertices) + extra + face + "\n")
    scene = read_scene(tmp_path / "a.obj")
    mesh = scene.meshes[0]
    np.testing.assert_allclose(mesh.colors[mesh.triangles[0]], LIGHTS, atol=1e-5)
    assert scene.materials[mesh.material].base_color == (1, 1, 1)


def test_stl_is_read_with_its_bounds(tmp_path):
    (tmp_path / "a.stl").write_bytes(STL)
    assert bounds_m(read_scene(tmp_path / "a.stl"), 1).tolist() == [[0, 1, 2], [6, 7, 8]]


TEXTURED_PLY = """ply
format ascii 1.0
comment TextureFile cloth.png
element vertex 3
property float x
property float y
property float z
property float s
property float t
element face 1
property list uchar int vertex_indices
end_header
0 0 0 0 0
1 0 0 1 0
0 1 0 0 1
3 0 1 2
"""


@pytest.mark.parametrize(
    ("picture", "message"),
    [(None, "cloth.png is missing"), (b"no picture", "unable to load image! cannot identify")],
)
def test_ply_texture_that_cannot_be_loaded_is_only_noted(tmp_path, picture, message):
    """Run in a process of its own, because pytest captures log messages."""
    (tmp_path / "a.ply").write_text(TEXTURED_PLY)
    if picture is not None:
        (tmp_path / "cloth.png").write_bytes(picture)
    process = start_heatlens("info", tmp_path / "a.ply")
    out, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0 and err == ""
    assert sum(message in line for line in out.splitlines()) == 1


FILES = {".obj": OBJ.encode(), ".ply": PLY, ".stl": STL}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("fuzz")


@given(st.sampled_from(sorted(FILES)), st.data())
@settings(deadline=None, max_examples=300)
def test_damaged_mesh_file_gives_scene_or_one_line_error(folder, suffix, data):
    whole = FILES[suffix]
    found = bytearray(whole[: data.draw(st.integers(0, len(whole)))])
    for at in data.draw(st.lists(st.integers(0, max(len(found) - 1, 0)), max_size=3)):
        if found:
            found[at] = data.draw(st.integers(0, 255))
    path = folder / f"a{suffix}"
    path.write_bytes(found)
    try:
        scene = read_scene(path)
    except HeatlensError as error:
        assert path.name in str(error)
        assert "\n" not in str(error)
    else:
        assert all(np.isfinite(mesh.positions_m).all() for mesh in scene.meshes)


LATIN_1 = OBJ.replace("usemtl red", "o Stühle\nusemtl red").encode("latin-1")


def test_obj_in_latin_1_is_read(tmp_path):
    (tmp_path / "a.obj").write_bytes(LATIN_1)
    (tmp_path / "a.mtl").write_bytes(MTL.replace("map_Kd", "# Möbel\nmap_Kd").encode("latin-1"))
    (tmp_path / "pic.png").write_bytes(encoded(PIXELS))
    scene = read_scene(tmp_path / "a.obj")
    assert scene.triangle_count == 2
    assert sorted(material.name for material in scene.materials) == ["blue", "red"]


def test_truncated_binary_stl_is_rejected(tmp_path):
    head = bytes(range(128, 208)) + struct.pack("<I", 2)
    for data in (head, head + STL[84:], head + STL[84:-9]):
        (tmp_path / "a.stl").write_bytes(data)
        with pytest.raises(
            InputError, match=r"a\.stl is (damaged|cut short) or not in the format STL"
        ) as found:
            read_scene(tmp_path / "a.stl")
        assert "module" not in str(found.value)


@pytest.mark.parametrize(("name", "data"), [("a.obj", LATIN_1), ("a.stl", b"\xff" * 90)])
def test_mesh_reading_without_encoding_library_names_extra(tmp_path, monkeypatch, name, data):
    monkeypatch.setitem(sys.modules, "charset_normalizer", None)
    (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError, match=r"more than is installed.*'heatlens\[scene\]'"):
        read_scene(tmp_path / name)


def test_mesh_reading_without_trimesh_names_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "trimesh", None)
    (tmp_path / "a.stl").write_bytes(STL)
    with pytest.raises(InputError, match=r"pip install 'heatlens\[scene\]'"):
        read_scene(tmp_path / "a.stl")


@pytest.mark.parametrize(
    "lines",
    [
        "v 0 0 0\nv 1 0 0\nv 1 1\nf 1 2 3\n",
        "v 0 0\nv 1 0\nv 1 1\nf 1 2 3\n",
        "v 1\nv 2\nv 3\nf 1 2 3\n",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 1 0\nvn 1 0\nvn 1 0\nf 1//1 2//2 3//3\n",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 1\nvt 0\nvt 1\nf 1/1 2/2 3/3\n",
        "v 0 0 0\nv 1 0 0 1 1\nv 1 1 0 2 2 2 2 2\nf 1 2 3\n",
    ],
)
def test_obj_with_short_or_long_lines_is_read_or_rejected(tmp_path, lines):
    """Lines hold too few or too many numbers: the face is read, or the file is reported."""
    (tmp_path / "short.obj").write_text(lines)
    try:
        scene = read_scene(tmp_path / "short.obj")
    except InputError as error:
        assert "short.obj is damaged" in str(error)
    else:
        assert scene.triangle_count == 1
        assert all(np.isfinite(mesh.positions_m).all() for mesh in scene.meshes)
