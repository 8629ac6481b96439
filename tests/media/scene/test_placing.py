"""Test unit and up axis of files without them: guessed, noted and stored in the shot."""

import struct
from dataclasses import replace

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import Framing, WorldAxis
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.media.scene.first_shot import first_shot
from heatlens.media.scene.placing import Placing, place_scene
from heatlens.media.scene.scene_bounds import bounds_m
from heatlens.media.scene.scene_read import read_scene
from support.gltf_files import square_scene
from support.mesh_files import OBJ

SIDES = (1.0, 2.0, 3.0)  # of a file, along x, y and z


def write_stl(path, scale=1.0):
    corner = [np.diag(SIDES)[i] * scale for i in range(3)]
    triangles = [(np.zeros(3), corner[0], corner[1]), (np.zeros(3), corner[1], corner[2])]
    rows = [struct.pack("<12fH", *np.zeros(3), *np.ravel(three), 0) for three in triangles]
    path.write_bytes(bytes(80) + struct.pack("<I", len(rows)) + b"".join(rows))
    return str(path)


def write_ply(path, comment=""):
    lines = ["ply", "format ascii 1.0", f"comment {comment}", "element vertex 3"]
    lines += [f"property float {axis}" for axis in "xyz"]
    lines += ["element face 1", "property list uchar int vertex_indices", "end_header"]
    path.write_text("\n".join([*lines, "0 0 0", "1 0 0", "1 2 3", "3 0 1 2", ""]))
    return str(path)


def scene_size(scene):
    return np.ptp(bounds_m(scene, 1), axis=0)


@pytest.mark.parametrize(("axis", "sides"), [("x", (2, 1, 3)), ("y", (1, 2, 3)), ("z", (1, 3, 2))])
def test_placing_turns_given_axis_up(tmp_path, axis, sides):
    text = write_stl(tmp_path / "a.stl")
    first = first_shot(text, placing=Placing(WorldAxis(axis), 0.5))
    np.testing.assert_allclose(scene_size(first.scene), np.multiply(sides, 0.5), rtol=1e-6)
    assert not first.scene.notes
    turn = first.scene.transforms_at(1)[0, :3, :3] / 0.5
    assert np.linalg.det(turn) == pytest.approx(1)  # nothing is mirrored
    assert turn[1, "xyz".index(axis)] == pytest.approx(1)


@pytest.mark.parametrize(
    ("name", "comment", "axis", "unit_m"),
    [
        ("small.stl", "", "z", 1.0),
        ("large.stl", "", "z", 1e-3),
        ("a.ply", "zipper output", "y", 1.0),
        ("b.ply", "Created in Blender version 5.0.1", "z", 1.0),
    ],
)
def test_guessed_placing_is_noted_and_stored_in_shot(tmp_path, name, comment, axis, unit_m):
    path = tmp_path / name
    file_path = (
        write_ply(path, comment)
        if path.suffix == ".ply"
        else write_stl(path, 40 if unit_m < 1 else 1)
    )
    first = first_shot(file_path)
    framing = first.shot.framing
    assert (framing.up_axis, framing.meters_per_unit) == (axis, unit_m)
    (note,) = first.scene.notes
    assert (
        f"{axis} is taken as up; change it with --up-axis" in note and "--meters-per-unit" in note
    )
    write_shot(tmp_path / "a.heatlens.json", first.shot)
    shot = read_shot(tmp_path / "a.heatlens.json")
    assert shot.framing == framing
    np.testing.assert_allclose(
        scene_size(place_scene(read_scene(file_path), shot.framing)), scene_size(first.scene)
    )


def test_stl_of_blender_is_in_meters(tmp_path):
    path = tmp_path / "a.stl"
    write_stl(path, 40)
    header = b"Exported from Blender-5.0.1".ljust(80, b"\0")
    path.write_bytes(header + path.read_bytes()[80:])
    assert first_shot(str(path)).shot.framing.meters_per_unit == 1.0


def test_placed_without_unit_keeps_numbers_of_file(tmp_path):
    scene = read_scene(write_stl(tmp_path / "a.stl", 40))
    assert place_scene(scene, Framing(640, 360)) is scene and place_scene(scene, None) is scene


def test_placed_twice_equals_placed_once(tmp_path):
    scene = read_scene(write_stl(tmp_path / "a.stl"))
    other = Framing(up_axis=WorldAxis.Z, meters_per_unit=0.01)
    twice = place_scene(
        place_scene(scene, Framing(up_axis=WorldAxis.X, meters_per_unit=3.0)), other
    )
    np.testing.assert_allclose(
        twice.transforms_at(1), place_scene(scene, other).transforms_at(1), atol=1e-12
    )


def test_placing_of_obj_is_y_up_in_meters_and_of_gltf_is_fixed(tmp_path):
    (tmp_path / "a.obj").write_text(OBJ)
    framing = first_shot(str(tmp_path / "a.obj")).shot.framing
    assert (framing.up_axis, framing.meters_per_unit) == ("y", 1.0)
    (tmp_path / "a.glb").write_bytes(square_scene().glb())
    with pytest.raises(InputError, match="leave --up-axis and"):
        first_shot(str(tmp_path / "a.glb"), placing=Placing(WorldAxis.Z))


def test_framing_rejects_impossible_unit():
    for unit_m in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(InputError, match="A unit has"):
            Framing(meters_per_unit=unit_m)
    shot = Shot(Lens(50.0, 2.8, 2.0, 36.0), framing=Framing(meters_per_unit=0.01))
    assert replace(shot).framing.meters_per_unit == 0.01
