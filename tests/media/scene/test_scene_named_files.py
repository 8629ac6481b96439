"""Test that files named by a glTF count as inputs: an export notices when they change."""

import json
import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.export.job import ExportJob
from heatlens.deliver.export.output import parse_output
from heatlens.deliver.export.plan import plan_export
from heatlens.fronts.commands.main import main
from heatlens.media.scene.gltf.file import named_files
from heatlens.media.scene.scene_read import files_of_scene, read_scene
from heatlens.studio.session.pictures import picture_commands
from support.exports import export_shot, refused_export_message
from support.gltf_files import GltfWriter, encoded, square_scene

TOLD = ("--f-stop=2", "--focus-distance=2.5", "--size=32x18", "--quality=draft")
GREY = [[[90, 90, 90]]]
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=9),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=9), inner),
    max_leaves=8,
)


@pytest.fixture
def scene(tmp_path) -> Path:
    """Return a square with a picture on it; its bytes and the picture lie beside the file."""
    folder = tmp_path / "scene"
    folder.mkdir()
    writer = textured_square(folder / "a map.png", "a%20map.png")
    (folder / "square.bin").write_bytes(writer.data)
    (folder / "square.gltf").write_bytes(writer.gltf("square.bin"))
    return folder / "square.gltf"


def textured_square(picture: Path, uri: str) -> GltfWriter:
    writer = GltfWriter()
    picture.write_bytes(encoded(GREY))
    texture = writer.add("textures", source=writer.add("images", uri=uri))
    look = {"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}}
    material = writer.add("materials", **look)
    writer.node(mesh=writer.mesh(material=material))
    return writer


def frame_fingerprint(scene: Path) -> str:
    """Return the fingerprint of the first frame of an export."""
    shot = Shot(Lens(50.0, 2.0, 2.0, 36.0), source=str(scene))
    job = ExportJob(shot, frames=(1,), output=parse_output(scene.parent.parent / "n.exr"))
    return plan_export(job).frames[0].fingerprint


def test_named_files_of_gltf_are_buffer_and_image(scene):
    folder = scene.parent.resolve()
    assert named_files(scene) == (folder / "square.bin", folder / "a map.png")
    assert files_of_scene(scene) == (scene, *named_files(scene))


@pytest.mark.parametrize("name", ["square.bin", "a map.png"])
@pytest.mark.parametrize("change", ["longer", "newer", "gone"])
def test_fingerprint_changes_with_each_named_file(scene, name, change):
    before, path = frame_fingerprint(scene), scene.parent / name
    assert frame_fingerprint(scene) == before
    if change == "longer":
        path.write_bytes(path.read_bytes() + b"\0")
    elif change == "newer":
        os.utime(path, ns=(5, 5))
    else:
        path.unlink()
    assert frame_fingerprint(scene) != before


def test_fingerprint_ignores_other_files_in_folder(scene):
    before = frame_fingerprint(scene)
    (scene.parent / "other.bin").write_bytes(b"1")
    assert frame_fingerprint(scene) == before


def test_export_renders_again_after_image_content_changes(capsys, scene, tmp_path):
    out = tmp_path / "n.exr"
    export_shot(capsys, scene, out, *TOLD)
    assert "1 was finished before" in export_shot(capsys, scene, out, *TOLD)
    (scene.parent / "a map.png").write_bytes(encoded([[[200, 20, 20], [20, 20, 200]]]))
    assert "1 frame written" in export_shot(capsys, scene, out, *TOLD)


@pytest.mark.parametrize("name", ["map.png", "./../scene/map.png", "link.png"])
def test_export_does_not_overwrite_image_of_scene(capsys, tmp_path, name):
    folder = tmp_path / "scene"
    folder.mkdir()
    textured_square(folder / "map.png", "map.png").write(folder / "scene.gltf")
    (folder / "link.png").symlink_to("map.png")
    before = (folder / "map.png").read_bytes()
    assert "an input of" in refused_export_message(
        capsys, folder / "scene.gltf", folder / name, *TOLD
    )
    assert (folder / "map.png").read_bytes() == before


def test_render_does_not_overwrite_image_of_scene(capsys, scene):
    path = scene.parent / "a map.png"
    before = path.read_bytes()
    os.link(path, scene.parent / "hard.png")
    for name in ("a map.png", "hard.png"):
        out = str(scene.parent / name)
        assert main(["render", str(scene), "-o", out, "--f-stop=2", "--focus-distance=2"]) == 2
        assert "is part of square.gltf" in capsys.readouterr().err
    assert path.read_bytes() == before


def test_sources_of_scene_include_named_files(scene):
    assert picture_commands._source_files(scene) == files_of_scene(scene)
    scene.unlink()
    assert picture_commands._source_files(scene) == (scene,)


def test_export_into_folder_of_scene_is_allowed(capsys, scene):
    assert "1 frame written" in export_shot(capsys, scene, scene.parent / "other.png", *TOLD)


def test_named_files_of_glb_reads_only_its_json(tmp_path):
    path = tmp_path / "scene.glb"
    data = textured_square(tmp_path / "map.png", "map.png").glb()
    path.write_bytes(data)
    assert named_files(path) == (tmp_path.resolve() / "map.png",)
    assert len(read_scene(path).images) == 1
    path.write_bytes(data[: data.index(b"BIN\0")])
    assert named_files(path) == (tmp_path.resolve() / "map.png",)


@pytest.mark.parametrize("kind", ["scene.glb", "scene.gltf"])
def test_named_files_of_self_contained_scene_are_empty(tmp_path, kind):
    assert named_files(square_scene().write(tmp_path / kind)) == ()


@pytest.mark.parametrize(
    "uri",
    [
        *("../out.bin", "%2e%2e/out.bin", "/etc/passwd", "file:///etc/passwd"),
        *("http://example.org/a.bin", "//x/y", "a\0b", "loop"),
    ],
)
def test_named_files_ignores_paths_that_reading_rejects(tmp_path, uri):
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "loop").symlink_to("loop")
    path = tmp_path / "in" / "scene.gltf"
    path.write_bytes(square_scene().gltf(uri))
    files = named_files(path)
    assert files == () or files == ((tmp_path / "in").resolve() / "loop",)
    with pytest.raises(InputError, match="buffers"):
        read_scene(path)


def test_files_of_scene_of_other_format_is_that_file(tmp_path):
    assert files_of_scene(tmp_path / "mesh.stl") == (tmp_path / "mesh.stl",)


@pytest.mark.parametrize("content", [b"", b"glTF", b"glTF" + b"\xff" * 40, b"{", b"[]", b"\xff"])
def test_named_files_rejects_file_that_is_no_gltf(tmp_path, content):
    path = tmp_path / "scene.gltf"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"scene\.gltf"):
        named_files(path)
    with pytest.raises(InputError, match=r"gone\.gltf is not there"):
        named_files(tmp_path / "gone.gltf")


@given(JSON, JSON)
def test_named_files_of_any_lists_stay_in_folder_or_raise(tmp_path_factory, buffers, images):
    path = tmp_path_factory.mktemp("any") / "scene.gltf"
    path.write_text(json.dumps({"buffers": buffers, "images": images}), "utf-8")
    try:
        files = named_files(path)
    except InputError as error:
        assert "scene.gltf" in str(error)
    else:
        assert all(file.is_relative_to(path.parent.resolve()) for file in files)
