"""Test that files named by an OBJ count as inputs: an export checks and never overwrites them."""

import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.errors import InputError
from heatlens.media.scene.obj_files import files_of_obj
from heatlens.media.scene.scene_read import files_of_scene, read_scene
from support.exports import export_shot, refused_export_message
from support.gltf_files import encoded
from support.watched_calls import watch_calls

TOLD = ("--f-stop=2", "--focus-distance=2.5", "--size=32x18", "--quality=draft")
RED, BLUE = [[[200, 30, 30]]], [[[30, 30, 200]]]
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl skin\nf 1/1 2/1 3/1\n"


@pytest.fixture
def scene(tmp_path) -> Path:
    """Return a triangle with a picture on it, in a folder of its own."""
    folder = tmp_path / "scene"
    (folder / "maps").mkdir(parents=True)
    (folder / "a map.png").write_bytes(encoded(RED))
    (folder / "maps" / "other.png").write_bytes(encoded(BLUE))
    (folder / "look.mtl").write_text(
        "newmtl skin\nKd 1 1 1\nmap_Kd a map.png\nnewmtl other\n\tMAP_KD maps\\other.png \n"
    )
    (folder / "mesh.obj").write_text("# made by hand\nmtllib look.mtl\n" + TRIANGLE)
    return folder / "mesh.obj"


def test_files_of_obj_are_the_files_that_are_read(scene, monkeypatch):
    folder = scene.parent.resolve()
    expected = tuple(folder / name for name in ("look.mtl", "a map.png", "maps/other.png"))
    assert files_of_obj(scene) == expected
    assert files_of_scene(scene) == (scene, *expected)
    calls = watch_calls(monkeypatch, os, "open")
    read_scene(scene)
    assert {scene, *expected} == {Path(path) for path, *_ in calls}


@pytest.mark.parametrize("name", ["look.mtl", "a map.png"])
def test_export_renders_again_after_obj_material_or_image_changes(capsys, scene, tmp_path, name):
    out, path = tmp_path / "n.exr", scene.parent / name
    export_shot(capsys, scene, out, *TOLD)
    assert "1 was finished before" in export_shot(capsys, scene, out, *TOLD)
    data = encoded([*BLUE, *RED]) if name.endswith("png") else path.read_bytes() + b"Ns 50\n"
    path.write_bytes(data)
    assert "1 frame written" in export_shot(capsys, scene, out, *TOLD)


def test_export_does_not_overwrite_image_of_obj(capsys, scene):
    path = scene.parent / "a map.png"
    before = path.read_bytes()
    assert "an input of" in refused_export_message(capsys, scene, path, *TOLD)
    assert path.read_bytes() == before


@pytest.mark.parametrize("name", ["../out.mtl", "/etc/passwd", "a\0b", "", "loop", "..\\out.mtl"])
def test_files_of_obj_ignores_names_outside_the_folder(tmp_path, name):
    folder = tmp_path / "in"
    folder.mkdir()
    (tmp_path / "out.mtl").write_text("newmtl a\nmap_Kd a.png\n")
    (folder / "loop").symlink_to("loop")
    for text in (f"mtllib {name}\n{TRIANGLE}", f"mtllib look.mtl\n{TRIANGLE}"):
        (folder / "look.mtl").write_text(f"newmtl skin\nmap_Kd {name}\n")
        (folder / "mesh.obj").write_text(text)
        files = files_of_obj(folder / "mesh.obj")
        assert all(path.is_relative_to(folder.resolve()) for path in files)
        assert read_scene(folder / "mesh.obj").triangle_count == 1


def test_files_of_obj_includes_missing_material_library(scene):
    (scene.parent / "look.mtl").unlink()
    assert files_of_obj(scene) == (scene.parent.resolve() / "look.mtl",)


@pytest.mark.parametrize("text", ["", TRIANGLE, "\xe9\n"])
def test_files_of_obj_without_library_are_empty(tmp_path, text):
    (tmp_path / "mesh.obj").write_bytes(text.encode("latin-1"))
    assert files_of_obj(tmp_path / "mesh.obj") == ()


def test_files_of_obj_reads_continued_lines_and_latin_1(tmp_path):
    (tmp_path / "mesh.obj").write_bytes(b"v 0 0 0\r\nmtllib lo\\\r\nok\xe9.mtl\r\nmtllib no.mtl")
    assert files_of_obj(tmp_path / "mesh.obj") == (tmp_path.resolve() / "look\xe9.mtl",)


def test_files_of_scene_reports_missing_obj(tmp_path):
    with pytest.raises(InputError, match=r"mesh\.obj is not there"):
        files_of_scene(tmp_path / "mesh.obj")


@given(st.binary(max_size=40), st.binary(max_size=40))
def test_files_of_obj_of_any_content_stay_inside_folder(tmp_path_factory, name, picture):
    folder = tmp_path_factory.mktemp("any")
    (folder / "mesh.obj").write_bytes(b"mtllib " + name)
    (folder / "look.mtl").write_bytes(b"map_Kd " + picture)
    for path in (folder / "mesh.obj", folder / "plain.obj"):
        path.write_bytes(path.read_bytes() if path.exists() else b"mtllib look.mtl\n")
        assert all(file.is_relative_to(folder.resolve()) for file in files_of_obj(path))
