"""The script for Blender, run with a stand-in for Blender's module that remembers every key."""

import math
import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.camera.blender_write import blender_text
from heatlens.camera.camera_file import write_camera
from heatlens.camera.samples import INFINITE_M
from heatlens.source.shot_camera import camera_of_shot
from support.cameras import FRAMES, SHOTS, TARGET, dolly, moving_camera


class Block(SimpleNamespace):
    """A data-block: attributes, and keys that take what they find."""

    def __init__(self, **values: object) -> None:
        super().__init__(keys={}, **values)

    def keyframe_insert(self, data_path: str, frame: int) -> None:
        value = self
        for part in data_path.split("."):
            value = getattr(value, part)
        self.keys.setdefault(data_path, {})[frame] = value

    def animation_data_clear(self) -> None:
        self.keys.clear()

    def copy(self) -> "Block":
        twin = Block(**{name: value for name, value in vars(self).items() if name != "keys"})
        twin.keys = {path: dict(keys) for path, keys in self.keys.items()}
        return twin

    def at(self, path: str, frame: int) -> object:
        """What an animated property is at a frame that may have a key."""
        if path in self.keys:
            return self.keys[path][frame]
        value = self
        for part in path.split("."):
            value = getattr(value, part)
        return value


def camera_data(name: str) -> Block:
    return Block(name=name, lens=35.0, dof=SimpleNamespace(use_dof=False, focus_object="Cube"))


def blender(active: Block | None = None, unit_m: float = 1.0) -> ModuleType:
    """As much of bpy as a script for cameras needs."""
    linked: list[Block] = []
    scene = SimpleNamespace(unit_settings=SimpleNamespace(scale_length=unit_m), camera=None)
    bpy = ModuleType("bpy")
    bpy.context = SimpleNamespace(
        object=active,
        scene=scene,
        collection=SimpleNamespace(objects=SimpleNamespace(link=linked.append)),
    )
    bpy.data = SimpleNamespace(
        cameras=SimpleNamespace(new=camera_data),
        objects=SimpleNamespace(new=lambda name, data: Block(name=name, data=data, type="CAMERA")),
    )
    bpy.linked = linked
    return bpy


def run(text: str, bpy: ModuleType) -> Block:
    """The camera that the script leaves in the scene."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "bpy", bpy)
        exec(compile(text, "camera.py", "exec"), {"__name__": "__main__"})
    return bpy.context.scene.camera


def test_a_new_camera_has_the_lens_at_every_frame(tmp_path):
    camera = moving_camera()
    write_camera(tmp_path / "cam.py", camera)
    bpy = blender()
    made = run((tmp_path / "cam.py").read_text(), bpy)
    assert bpy.linked == [made] and made.name == "hero cam"
    data = made.data
    assert (data.sensor_fit, data.sensor_width, data.sensor_height) == ("HORIZONTAL", 36.0, 20.25)
    assert data.dof.use_dof and data.dof.focus_object is None
    assert (data.dof.aperture_fstop, data.dof.aperture_ratio) == (1.3, 1.8)
    assert set(data.keys) == {"lens", "dof.focus_distance"}
    for index, frame in enumerate(FRAMES):
        assert data.at("lens", frame) == camera.focal_length_mm[index]
        focus_m = min(camera.focus_distance_m[index], INFINITE_M)
        assert data.at("dof.focus_distance", frame) == focus_m


@given(SHOTS, st.sampled_from([1.0, 0.01]))
def test_the_lens_of_any_shot_is_at_every_frame(shot, unit_m):
    data = run(blender_text(camera_of_shot(shot, "cam")), blender(unit_m=unit_m)).data
    for frame in FRAMES:
        lens = shot.lens_at(frame)
        assert data.at("lens", frame) == lens.focal_length_mm
        assert data.at("dof.aperture_fstop", frame) == lens.f_stop
        assert data.at("dof.aperture_ratio", frame) == lens.squeeze
        focus_m = min(lens.focus_distance_m, INFINITE_M)
        found = data.at("dof.focus_distance", frame)
        assert found * unit_m == pytest.approx(focus_m, rel=1e-12)


@pytest.mark.parametrize("unit_m", [1.0, 0.01])
def test_it_stands_where_the_plate_was_seen_from_with_z_up(unit_m):
    made = run(blender_text(moving_camera()), blender(unit_m=unit_m))
    assert made.rotation_mode == "XYZ"
    for frame, eye in zip(FRAMES, dolly(), strict=True):
        turn = turned(made.at("rotation_euler", frame))
        forward = np.subtract(TARGET, eye) / np.linalg.norm(np.subtract(TARGET, eye))
        assert turn @ (0, 0, -1) == pytest.approx(z_up(forward), abs=1e-9)
        assert (turn @ (1, 0, 0))[2] == pytest.approx(0, abs=1e-9)  # level
        where = np.multiply(made.at("location", frame), unit_m)
        assert where == pytest.approx(z_up(eye), abs=1e-9)


def z_up(point):
    """A point of a world with y up, in one with z up."""
    x, y, z = point
    return (x, -z, y)


def turned(angles) -> np.ndarray:
    """Blender's XYZ: about x first, z last, in radians."""
    made = np.eye(3)
    for axis, angle in enumerate(angles):
        c, s = math.cos(angle), math.sin(angle)
        i, j = (axis + 1) % 3, (axis + 2) % 3
        step = np.eye(3)
        step[[i, j, i, j], [i, j, j, i]] = c, c, -s, s
        made = step @ made
    return made


def test_the_active_camera_takes_the_lens_and_keeps_its_place():
    """Old keys of its lens are gone, and another object with the same lens keeps them."""
    shared = camera_data("old")
    shared.keyframe_insert("lens", 7)
    active = Block(name="shot cam", type="CAMERA", data=shared, location=(1, 2, 3))
    active.keyframe_insert("location", 5)
    bpy = blender(active)
    made = run(blender_text(moving_camera(world_to_camera=None)), bpy)
    assert made is active and bpy.linked == []
    assert (active.location, active.keys) == ((1, 2, 3), {"location": {5: (1, 2, 3)}})
    assert list(active.data.keys["lens"]) == list(FRAMES)
    assert shared.keys == {"lens": {7: 35.0}}


def test_another_active_object_is_left_alone():
    cube = Block(name="Cube", type="MESH", data=None)
    bpy = blender(cube)
    made = run(blender_text(moving_camera()), bpy)
    assert made is not cube and cube.data is None


def test_the_scenes_own_camera_stays():
    bpy = blender()
    bpy.context.scene.camera = "main"
    assert run(blender_text(moving_camera()), bpy) == "main"


def test_without_a_focus_depth_of_field_stays_as_it_is():
    bare = moving_camera(focus_distance_m=None, f_stop=None, squeeze=None)
    made = run(blender_text(bare), blender())
    assert made.data.dof == SimpleNamespace(use_dof=False, focus_object="Cube")


@given(st.text())
def test_no_name_breaks_the_script(name):
    assert run(blender_text(moving_camera(name=name)), blender()).name == name
