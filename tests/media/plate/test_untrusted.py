"""Test hostile files: false sizes, endless reads, and terminal control sequences."""

import json
import os
import struct

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.base.messages import window_words
from heatlens.core.base.outside_text import printable
from heatlens.fronts.commands.main import main
from heatlens.media.camera.camera_file import read_camera
from heatlens.media.camera.rows import json_text
from heatlens.media.color.color_config import load_color_config
from heatlens.media.files.json_record import read_json
from heatlens.media.files.quiet import quiet_library
from heatlens.media.scene import picture_read
from heatlens.media.scene.picture_read import read_picture
from heatlens.media.scene.scene_read import files_of_scene, read_scene
from support.cameras import moving_camera
from support.exr_files import distances, rgb, write_file
from support.gltf_files import encoded

TRIANGLE = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
NASTY = "\x1b]0;PWN\x07\x1b[31m\nheatlens: forged line\u202e\x9b2J"


def write_triangle_gltf(folder, **changes):
    """Write one triangle with its bytes in a.bin; `changes` replaces entries of the file."""
    (folder / "a.bin").write_bytes(TRIANGLE)
    value = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": "a.bin", "byteLength": len(TRIANGLE)}],
        "bufferViews": [{"buffer": 0, "byteLength": len(TRIANGLE)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "nodes": [{"mesh": 0, "name": "thing"}],
        "scenes": [{"nodes": [0]}],
    }
    path = folder / "a.gltf"
    path.write_text(json.dumps(value | changes))
    return path


# Claims


def test_gltf_accessors_without_bytes_share_one_limit(tmp_path):
    empty = [{"componentType": 5126, "count": 300_000, "type": "VEC3"} for _ in range(6)]
    meshes = [{"primitives": [{"attributes": {"POSITION": i}} for i in range(6)]}]
    path = write_triangle_gltf(tmp_path, accessors=empty, meshes=meshes)
    with pytest.raises(InputError, match=r"accessors\[4\].*4,000,000 are the most in one file"):
        read_scene(path)


def test_gltf_meshes_that_share_bytes_share_one_limit(tmp_path, monkeypatch):
    monkeypatch.setattr("heatlens.media.scene.gltf.file._NUMBERS_MOST", 50)
    meshes = [{"primitives": [{"attributes": {"POSITION": 0}}] * 6}]
    with pytest.raises(InputError, match=r"with all before it; 50 are the most in one file"):
        read_scene(write_triangle_gltf(tmp_path, meshes=meshes))


def test_gltf_buffers_share_one_limit(tmp_path, monkeypatch):
    monkeypatch.setattr("heatlens.media.scene.gltf.file._BUFFERS_MOST", len(TRIANGLE))
    assert read_scene(write_triangle_gltf(tmp_path)).triangle_count == 1
    buffers = [{"uri": "a.bin", "byteLength": len(TRIANGLE)}] * 2
    views = [{"buffer": i, "byteLength": len(TRIANGLE)} for i in range(2)]
    accessors = [
        {"bufferView": i, "componentType": 5126, "count": 3, "type": "VEC3"} for i in range(2)
    ]
    meshes = [{"primitives": [{"attributes": {"POSITION": i}} for i in range(2)]}]
    path = write_triangle_gltf(
        tmp_path, buffers=buffers, bufferViews=views, accessors=accessors, meshes=meshes
    )
    with pytest.raises(InputError, match=r"buffers\[1\].*together"):
        read_scene(path)


@pytest.mark.parametrize("count", [255, 256, 20_000])
def test_gltf_chain_of_nodes_is_limited(tmp_path, count):
    nodes: list[dict] = [{"children": [i + 1]} for i in range(count)]
    path = write_triangle_gltf(tmp_path, nodes=[*nodes, {"mesh": 0}])
    if count < 256:
        assert read_scene(path).triangle_count == 1
        return
    with pytest.raises(InputError, match="has more than 256 ancestors"):
        read_scene(path)


def test_gltf_number_of_objects_is_limited(tmp_path, monkeypatch):
    monkeypatch.setattr("heatlens.media.scene.scene.INSTANCES_MOST", 7)
    nodes = [{"mesh": 0} for _ in range(8)]
    assert len(read_scene(write_triangle_gltf(tmp_path, nodes=nodes[:7], scenes=[])).instances) == 7
    with pytest.raises(InputError, match="8 objects or more; heatlens draws 7"):
        read_scene(write_triangle_gltf(tmp_path, nodes=nodes, scenes=[]))


def test_scene_pictures_share_one_limit(monkeypatch):
    data = encoded(np.zeros((4, 4, 3), np.uint8))
    monkeypatch.setattr(picture_read, "_TOGETHER_MOST", 32)
    first = read_picture(data, "a")
    second = read_picture(data, "b", [first])
    with pytest.raises(InputError, match="c: all pictures of a scene may have 32 pixels together"):
        read_picture(data, "c", [first, second])


# What never ends


@pytest.fixture
def pipe(tmp_path):
    """Return a named pipe that nobody writes to: whoever opens it waits."""
    os.mkfifo(tmp_path / "pipe")
    return tmp_path / "pipe"


def test_read_scene_does_not_wait_for_pipe(tmp_path, pipe):
    buffers = [{"uri": "pipe", "byteLength": len(TRIANGLE)}]
    with pytest.raises(InputError, match="'pipe' cannot be read: it is not a file"):
        read_scene(write_triangle_gltf(tmp_path, buffers=buffers))
    obj = tmp_path / "a.obj"
    obj.write_text("mtllib pipe\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert "pipe is missing" in read_scene(obj).notes[0]
    assert pipe in files_of_scene(obj)


@pytest.mark.parametrize("suffix", [".json", ".csv", ".usda"])
def test_read_camera_rejects_pipe(tmp_path, pipe, suffix):
    renamed = pipe.rename(tmp_path / f"cam{suffix}")
    with pytest.raises(InputError, match="not a file"):
        read_camera(str(renamed))


@pytest.mark.parametrize("suffix", [".glb", ".gltf", ".obj", ".ply", ".stl", ".usda"])
def test_read_scene_rejects_pipe(tmp_path, pipe, suffix):
    renamed = pipe.rename(tmp_path / f"a{suffix}")
    with pytest.raises(InputError, match="not a file"):
        read_scene(renamed)


def test_read_scene_of_usd_rejects_device_as_texture(tmp_path, pipe):
    stage = """#usda 1.0
( metersPerUnit = 1 )
def Mesh "m" (prepend apiSchemas = ["MaterialBindingAPI"])
{
 rel material:binding = </mat>
 int[] faceVertexCounts = [3]
 int[] faceVertexIndices = [0, 1, 2]
 point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
}
def Material "mat"
{
 token outputs:surface.connect = </mat/s.outputs:surface>
 def Shader "s"
 {
  uniform token info:id = "UsdPreviewSurface"
  color3f inputs:diffuseColor.connect = </mat/t.outputs:rgb>
  token outputs:surface
 }
 def Shader "t"
 {
  uniform token info:id = "UsdUVTexture"
  asset inputs:file = @%s@
  float3 outputs:rgb
 }
}
"""
    for name in ("/dev/zero", "./pipe"):
        (tmp_path / "a.usda").write_text(stage % name)
        scene = read_scene(tmp_path / "a.usda")
        assert any("is not a file" in note for note in scene.notes)


# What is shown


def test_printable_escapes_control_characters_and_keeps_letters():
    assert printable(NASTY) == r"\x1b]0;PWN\x07\x1b[31m\nheatlens: forged line\u202e\x9b2J"
    for plain in ("Straße_01.exr", "焦点", "f/2 – 3′", "a\u200db"):
        assert printable(plain) == plain
    assert printable("a\nb", keep="\n") == "a\nb"
    assert printable(os.fsdecode(b"\xff.exr")) == r"\udcff.exr"


def test_info_escapes_names_in_files(tmp_path, capsys):
    plate = write_file(
        tmp_path / "p.exr", rgb() | {"Z": distances(), NASTY: distances()}, colorInteropID=NASTY
    )
    nodes = [{"mesh": 0, "name": NASTY}, {"camera": 0, "name": NASTY}]
    cameras = [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}, "name": NASTY}]
    scene = write_triangle_gltf(tmp_path, nodes=nodes, cameras=cameras, scenes=[{"nodes": [0, 1]}])
    for path in (plate, scene):
        assert main(["info", str(path)]) == 0
        output = capsys.readouterr()
        assert printable(output.out + output.err, keep="\n") == output.out + output.err
        assert r"\x1b]0;PWN\x07" in output.out and "\nheatlens: forged" not in output.out


def test_error_messages_escape_file_names(tmp_path, capsys):
    name = str(tmp_path / NASTY.replace("/", ""))
    assert main(["info", f"{name}.exr"]) == 2
    stderr = capsys.readouterr().err
    assert len(stderr.splitlines()) == 1 and printable(stderr, keep="\n") == stderr
    assert window_words(NASTY) == printable(NASTY)


def test_info_json_keeps_names_unchanged(tmp_path, capsys):
    plate = write_file(tmp_path / "p.exr", rgb() | {"Z": distances(), NASTY: distances()})
    assert main(["info", "--json", str(plate)]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert NASTY in facts["parts"][0]["channels"]


def test_quiet_library_drops_output_of_c_code(capfd):
    """OpenJPH prints remarks about a damaged file on stdout."""
    with quiet_library():
        os.write(1, b"ojph info from C\n")
    print("{}", flush=True)
    assert capfd.readouterr().out == "{}\n"


# Names and configs


@pytest.mark.parametrize("data", [b"ocio_profile_version: 2\nname: \xca\n", b"\xff\xfe\x00"])
def test_load_color_config_rejects_file_that_is_no_utf_8(tmp_path, data):
    path = tmp_path / "c.ocio"
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"c\.ocio is not a usable OpenColorIO config: byte"):
        load_color_config(str(path))


def test_load_color_config_rejects_pipe(tmp_path, pipe):
    with pytest.raises(InputError, match="not a file"):
        load_color_config(str(pipe))


def test_read_camera_of_json_text_works(tmp_path):
    path = tmp_path / "cam.json"
    path.write_text(json_text(moving_camera()))
    assert read_camera(str(path)).name == moving_camera().name
    assert read_json(path).value["heatlens_camera"]
