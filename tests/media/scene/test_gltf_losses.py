"""Test that everything a glTF reader leaves out is noted once, with its count."""

import re

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.media.scene.gltf.file import READ_EXTENSIONS
from heatlens.media.scene.gltf.vocabulary import KINDS
from heatlens.media.scene.scene_read import read_scene
from support.gltf_files import SQUARE, SQUARE_UVS, GltfWriter, figure_scene, square_scene

FOURS = np.tile(np.float32([1, 0, 0, 0]), (4, 1))
BONES = np.zeros((4, 4), np.uint8)


def scene_notes(writer, tmp_path):
    """Return the notes of a file, without its name."""
    path = writer.write(tmp_path / "a.glb")
    return [note.removeprefix(f"{path}: ") for note in read_scene(path).notes]


def scene_with_primitive(attributes=(), node=(), material=None, **primitive):
    writer = GltfWriter()
    if material is not None:
        primitive["material"] = writer.add("materials", **material(writer))
    writer.node(mesh=writer.mesh(attributes=attributes, **primitive), **dict(node))
    writer.add("skins", joints=[0])
    return writer


def scene_with_channel(path, **target):
    writer = square_scene()
    writer.animate(0, path, [0, 1], [[0, 0, 0], [1, 0, 0]])
    writer.json["animations"][0]["channels"][0]["target"] |= target
    return writer


def pointer(place):
    return {"extensions": {"KHR_animation_pointer": {"pointer": place}}}


def scene_with_repeated_channels():
    writer = square_scene()
    for _ in range(3):
        writer.animate(0, "translation", [0, 1], [[0, 0, 0], [1, 0, 0]])
    return writer


def scene_with_weights(count):
    writer = scene_with_primitive()
    shape = {"POSITION": writer.accessor(SQUARE), "TEXCOORD_0": writer.accessor(SQUARE_UVS)}
    writer.json["meshes"][0]["primitives"][0]["targets"] = [shape]
    writer.json["meshes"][0]["weights"] = [1] * count
    return writer


def scene_with_sampler(kind):
    def material(writer):
        writer.add("samplers", magFilter=kind)
        number = writer.picture([[[255, 0, 0]]])
        writer.json["textures"][number]["sampler"] = 0
        return {"emissiveTexture": {"index": number}}

    return scene_with_primitive({"TEXCOORD_0": SQUARE_UVS}, material=material)


def scene_with_suns(count):
    writer = square_scene()
    for _ in range(count):
        writer.node(**writer.light(type="directional", intensity=2, range=5))
    return writer


def scene_with_camera(**perspective):
    writer = square_scene()
    writer.add("cameras", type="perspective", perspective={"yfov": 0.6, **perspective})
    writer.node(camera=0, translation=[0, 0, 5])
    return writer


def with_unknown_entries():
    writer = scene_with_primitive(
        {"COLOR_0": FOURS, "COLOR_1": FOURS, "_MINE": FOURS}, node={"shape": 1}
    )
    writer.json["extras"] = {"anything": 1}
    writer.node(extensions={"ACME_fog": {}})
    writer.node(extensions={"ACME_fog": {}})
    return writer


def without_coordinates(writer):
    return {"emissiveTexture": {"index": writer.picture([[[255, 0, 0]]])}}


@pytest.mark.parametrize(
    ("writer", "words"),
    [
        (scene_with_primitive({"JOINTS_0": BONES}, {"skin": 0}), ["without weights"]),
        (scene_with_primitive({"WEIGHTS_0": FOURS}, {"skin": 0}), ["without weights"]),
        (scene_with_primitive({"JOINTS_0": BONES, "WEIGHTS_0": FOURS}), ["without a skeleton"]),
        (
            scene_with_channel("pointer", **pointer("/materials/0/alphaCutoff")),
            ["anything but nodes"],
        ),
        (scene_with_channel("colour"), ["anything but nodes"]),
        (scene_with_channel("weights"), ["without morph targets"]),
        (scene_with_repeated_channels(), [r"the first is played.*\(2\)"]),
        (scene_with_weights(3), [r"missing morph targets", r"targets of colours.*\(1\)"]),
        (scene_with_sampler(9728), [r"nearest-pixel.*\(1\)"]),
        (scene_with_sampler(9729), []),
        (scene_with_suns(3), [r"Suns except.*\(2\)", r"range of lights is ignored \(3\)"]),
        (scene_with_camera(znear=0.1, zfar=100.0), []),
        (scene_with_camera(znear=5.1), [r"clipping planes.*\(1\)"]),
        (scene_with_camera(zfar=4.0), [r"clipping planes.*\(1\)"]),
        (
            with_unknown_entries(),
            [r"after the first.*\(1\)", r"ACME_fog \(2\)", r"'node.shape' \(1\)"],
        ),
        (scene_with_primitive(material=without_coordinates), ["without texture coordinates"]),
        (scene_with_primitive(mode=0), [r"thin \(1\)"]),
        (figure_scene(), ["candela", "lines are drawn thin", "Glass"]),
        (square_scene(), []),
    ],
)  # fmt: skip
def test_gltf_losses_are_noted_once_with_count(tmp_path, writer, words):
    notes = scene_notes(writer, tmp_path)
    for pattern in words:
        assert len([note for note in notes if re.search(pattern, note)]) == 1, (pattern, notes)
    assert len(notes) == len(words), notes


def test_gltf_read_extensions_have_listed_properties():
    assert READ_EXTENSIONS <= set(KINDS)
    for kind in KINDS.values():
        assert set(kind.within.values()) <= set(KINDS)


def test_gltf_nested_extensions_are_limited(tmp_path):
    """A file may nest them deeper than Python can recurse."""
    inner: object = {}
    for _ in range(200):
        inner = {"extensions": {"KHR_texture_transform": inner}}
    writer = square_scene()
    writer.json["materials"] = [{"extensions": {"VENDOR": 1}, "normalTexture": inner}]
    assert "VENDOR (1)" in scene_notes(writer, tmp_path)[0]


def test_gltf_of_later_version_is_rejected(tmp_path):
    writer = square_scene()
    writer.json["asset"]["minVersion"] = "2.1"
    with pytest.raises(InputError, match=r"needs glTF of version '2\.1'"):
        scene_notes(writer, tmp_path)


def test_gltf_hidden_node_hides_its_children(tmp_path):
    writer = square_scene()
    child = writer.node(is_root=False, mesh=0, name="child")
    hidden = {"KHR_node_visibility": {"visible": False}}
    writer.node(extensions=hidden, mesh=0, children=[child], name="parent")
    names = [instance.name for instance in read_scene(writer.write(tmp_path / "a.glb")).instances]
    assert names == ["node 0"]


def test_gltf_animation_pointer_moves_node_and_zooms_camera(tmp_path):
    writer = scene_with_camera()
    writer.animate(0, "pointer", [0, 1], [[0, 0, 0], [6, 0, 0]])
    writer.animate(0, "pointer", [0, 1], [0.6, 0.3])
    places = ("/nodes/0/translation", "/cameras/0/perspective/yfov")
    for record, place in zip(writer.json["animations"], places, strict=True):
        record["channels"][0]["target"] = {"path": "pointer", **pointer(place)}
    scene = read_scene(writer.write(tmp_path / "a.glb"))
    assert scene.transforms_at(13)[0, 0, 3] == pytest.approx(3.0)
    (camera,) = scene.cameras
    lengths_mm = camera.lens_tracks["focal_length_mm"]
    assert camera.lens_frames == tuple(range(1, 26)) and not scene.notes
    angles = 2 * np.arctan(36 * 9 / 16 / 2 / np.array(lengths_mm))
    np.testing.assert_allclose(angles, np.linspace(0.6, 0.3, 25), rtol=1e-6)
