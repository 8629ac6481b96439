"""Test that the scene that was read last is given again only while its files are as they were."""

import os
import time
from pathlib import Path

import pytest

from heatlens.core.model.shot.framing import SceneTiming
from heatlens.media.scene import kept_scene
from heatlens.media.scene.scene_read import files_of_scene, open_scene
from support.gltf_files import GltfWriter, encoded


@pytest.fixture(autouse=True)
def none_kept(monkeypatch) -> None:
    monkeypatch.setattr(kept_scene, "_latest", [])


@pytest.fixture
def scene(tmp_path) -> Path:
    """Return a square with a picture, whose files are a minute old."""
    writer = GltfWriter()
    texture = writer.add("textures", source=writer.add("images", uri="map.png"))
    look = {"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}}
    writer.node(mesh=writer.mesh(material=writer.add("materials", **look)))
    (tmp_path / "map.png").write_bytes(encoded([[[90, 90, 90]]]))
    (tmp_path / "square.bin").write_bytes(writer.data)
    (tmp_path / "square.gltf").write_bytes(writer.gltf("square.bin"))
    for path in tmp_path.iterdir():
        make_old(path)
    return tmp_path / "square.gltf"


def make_old(path: Path) -> None:
    a_minute_ago = time.time() - 60.0
    os.utime(path, (a_minute_ago, a_minute_ago))


def test_scene_is_read_once_until_one_of_its_files_changes(scene):
    first = open_scene(str(scene))
    assert open_scene(str(scene)) is first
    (scene.parent / "map.png").write_bytes(encoded([[[9, 9, 9], [8, 8, 8]]]))
    second = open_scene(str(scene))
    assert second is not first and second.images[0].shape != first.images[0].shape


def test_removed_and_added_files_of_a_scene_are_noticed(scene):
    first = open_scene(str(scene))
    os.rename(scene.parent / "map.png", scene.parent / "kept.png")
    without = open_scene(str(scene))
    assert "left out" in without.notes[0] and "left out" not in first.notes[0]
    os.rename(scene.parent / "kept.png", scene.parent / "map.png")
    assert open_scene(str(scene)).notes == first.notes


def test_scene_is_read_again_with_another_timing(scene):
    first = open_scene(str(scene))
    other = open_scene(str(scene), SceneTiming(frames_per_second=48.0))
    assert (first.frames_per_second, other.frames_per_second) == (24.0, 48.0)


def test_scene_changed_shortly_before_is_not_kept(scene):
    """A second change could leave the same time and size."""
    os.utime(scene.parent / "map.png")
    assert open_scene(str(scene)) is not open_scene(str(scene))


def test_files_of_a_kept_scene_are_those_of_a_fresh_one(scene):
    fresh = files_of_scene(scene)
    open_scene(str(scene))
    assert kept_scene.kept_files(scene) == fresh == files_of_scene(scene)
    assert set(fresh) == set(scene.parent.iterdir())


def test_stage_of_usd_knows_the_files_that_it_names(tmp_path):
    (tmp_path / "card.usda").write_text(
        '#usda 1.0\ndef Mesh "card" {\n int[] faceVertexCounts = [3]\n'
        " int[] faceVertexIndices = [0, 1, 2]\n"
        " point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\n}\n"
    )
    (tmp_path / "stage.usda").write_text("#usda 1.0\n(subLayers = [@card.usda@])\n")
    for path in tmp_path.iterdir():
        make_old(path)
    stage = tmp_path / "stage.usda"
    fresh = files_of_scene(stage)
    scene = open_scene(str(stage))
    assert open_scene(str(stage)) is scene
    assert files_of_scene(stage) == fresh == (stage, *(scene.named_files or ()))
    assert (tmp_path / "card.usda").resolve() in fresh
