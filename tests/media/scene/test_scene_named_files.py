"""Files that a glTF names count as its own: an export sees when they are written again."""

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
from heatlens.deliver.export.plan import planned
from heatlens.fronts.commands.main import main
from heatlens.media.scene.gltf.file import named_files
from heatlens.media.scene.scene_read import files_of_scene, read_scene
from heatlens.studio.session.pictures import picture_commands
from support.exports import exported, refused
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
    writer = textured(folder / "a map.png", "a%20map.png")
    (folder / "square.bin").write_bytes(writer.data)
    (folder / "square.gltf").write_bytes(writer.gltf("square.bin"))
    return folder / "square.gltf"


def textured(picture: Path, uri: str) -> GltfWriter:
    writer = GltfWriter()
    picture.write_bytes(encoded(GREY))
    texture = writer.add("textures", source=writer.add("images", uri=uri))
    look = {"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}}
    material = writer.add("materials", **look)
    writer.node(mesh=writer.mesh(material=material))
    return writer


def mark(scene: Path) -> str:
    """Return the fingerprint of the first frame of an export."""
    shot = Shot(Lens(50.0, 2.0, 2.0, 36.0), source=str(scene))
    job = ExportJob(shot, (1,), parse_output(scene.parent.parent / "n.exr"))
    return planned(job).frames[0].fingerprint


def test_buffers_and_pictures_are_named(scene):
    folder = scene.parent.resolve()
    assert named_files(scene) == (folder / "square.bin", folder / "a map.png")
    assert files_of_scene(scene) == (scene, *named_files(scene))


@pytest.mark.parametrize("name", ["square.bin", "a map.png"])
@pytest.mark.parametrize("change", ["longer", "newer", "gone"])
def test_a_file_that_is_written_again_makes_another_source(scene, name, change):
    before, path = mark(scene), scene.parent / name
    assert mark(scene) == before
    if change == "longer":
        path.write_bytes(path.read_bytes() + b"\0")
    elif change == "newer":
        os.utime(path, ns=(5, 5))
    else:
        path.unlink()
    assert mark(scene) != before


def test_other_files_of_the_folder_do_not_count(scene):
    before = mark(scene)
    (scene.parent / "other.bin").write_bytes(b"1")
    assert mark(scene) == before


def test_an_export_renders_again_what_has_other_bytes(capsys, scene, tmp_path):
    out = tmp_path / "n.exr"
    exported(capsys, scene, out, *TOLD)
    assert "1 was finished before" in exported(capsys, scene, out, *TOLD)
    (scene.parent / "a map.png").write_bytes(encoded([[[200, 20, 20], [20, 20, 200]]]))
    assert "1 frame written" in exported(capsys, scene, out, *TOLD)


@pytest.mark.parametrize("name", ["map.png", "./../scene/map.png", "link.png"])
def test_an_export_is_not_written_over_a_picture_that_a_scene_is_made_of(capsys, tmp_path, name):
    folder = tmp_path / "scene"
    folder.mkdir()
    textured(folder / "map.png", "map.png").write(folder / "scene.gltf")
    (folder / "link.png").symlink_to("map.png")
    before = (folder / "map.png").read_bytes()
    assert "an input of" in refused(capsys, folder / "scene.gltf", folder / name, *TOLD)
    assert (folder / "map.png").read_bytes() == before


def test_a_picture_is_not_rendered_over_one_that_a_scene_names(capsys, scene):
    path = scene.parent / "a map.png"
    before = path.read_bytes()
    os.link(path, scene.parent / "hard.png")
    for name in ("a map.png", "hard.png"):
        out = str(scene.parent / name)
        assert main(["render", str(scene), "-o", out, "--f-stop=2", "--focus-distance=2"]) == 2
        assert "is part of square.gltf" in capsys.readouterr().err
    assert path.read_bytes() == before


def test_what_a_scene_names_is_guarded_though_its_file_is_gone(scene):
    assert picture_commands._sources(scene) == files_of_scene(scene)
    scene.unlink()
    assert picture_commands._sources(scene) == (scene,)


def test_an_export_beside_a_scene_is_written(capsys, scene):
    assert "1 frame written" in exported(capsys, scene, scene.parent / "other.png", *TOLD)


def test_a_glb_names_pictures_too_and_only_its_json_is_read(tmp_path):
    path = tmp_path / "scene.glb"
    data = textured(tmp_path / "map.png", "map.png").glb()
    path.write_bytes(data)
    assert named_files(path) == (tmp_path.resolve() / "map.png",)
    assert len(read_scene(path).images) == 1
    path.write_bytes(data[: data.index(b"BIN\0")])
    assert named_files(path) == (tmp_path.resolve() / "map.png",)


@pytest.mark.parametrize("kind", ["scene.glb", "scene.gltf"])
def test_what_lies_within_the_file_names_nothing(tmp_path, kind):
    assert named_files(square_scene().write(tmp_path / kind)) == ()


@pytest.mark.parametrize(
    "uri",
    [
        *("../out.bin", "%2e%2e/out.bin", "/etc/passwd", "file:///etc/passwd"),
        *("http://example.org/a.bin", "//x/y", "a\0b", "loop"),
    ],
)
def test_what_reading_refuses_is_not_looked_at(tmp_path, uri):
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "loop").symlink_to("loop")
    path = tmp_path / "in" / "scene.gltf"
    path.write_bytes(square_scene().gltf(uri))
    named = named_files(path)
    assert named == () or named == ((tmp_path / "in").resolve() / "loop",)
    with pytest.raises(InputError, match="buffers"):
        read_scene(path)


def test_other_scenes_are_one_file(tmp_path):
    assert files_of_scene(tmp_path / "mesh.stl") == (tmp_path / "mesh.stl",)


@pytest.mark.parametrize("content", [b"", b"glTF", b"glTF" + b"\xff" * 40, b"{", b"[]", b"\xff"])
def test_what_is_no_gltf_is_refused_in_a_sentence(tmp_path, content):
    path = tmp_path / "scene.gltf"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"scene\.gltf"):
        named_files(path)
    with pytest.raises(InputError, match=r"gone\.gltf is not there"):
        named_files(tmp_path / "gone.gltf")


@given(JSON, JSON)
def test_whatever_stands_in_the_lists_is_read_or_refused(tmp_path_factory, buffers, images):
    path = tmp_path_factory.mktemp("any") / "scene.gltf"
    path.write_text(json.dumps({"buffers": buffers, "images": images}), "utf-8")
    try:
        named = named_files(path)
    except InputError as error:
        assert "scene.gltf" in str(error)
    else:
        assert all(file.is_relative_to(path.parent.resolve()) for file in named)
