"""Test the Blender script, run with a stand-in for Blender's module that records every key."""

import math
import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens, LensModel
from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.core.model.shot.shot import Shot
from heatlens.media.camera.blender_write import blender_text
from heatlens.media.camera.camera_file import write_camera
from heatlens.media.camera.samples import INFINITE_M, with_renderer_f_stop
from heatlens.render.source.named import camera_of_shot
from support.cameras import FRAMES, SHOTS, TARGET, dolly, moving_camera


class Block(SimpleNamespace):
    """Stand in for a Blender data-block: attributes, custom properties and recorded keys."""

    def __init__(self, **values: object) -> None:
        super().__init__(keys={}, own={}, curves={}, **values)
        action = SimpleNamespace(fcurves=self.curves.values())
        self.animation_data = SimpleNamespace(action=action)  # as before Blender 4.4

    def __setitem__(self, name: str, value: object) -> None:
        self.own[name] = value

    def pop(self, name: str, default: object) -> object:
        return self.own.pop(name, default)

    def value_of(self, path: str) -> object:
        if path.startswith("["):
            return self.own[path.strip('[]"')]
        value = self
        for part in path.split("."):
            value = getattr(value, part)
        return value

    def keyframe_insert(self, data_path: str, frame: int) -> None:
        self.keys.setdefault(data_path, {})[frame] = self.value_of(data_path)
        curve = SimpleNamespace(data_path=data_path, keyframe_points=[])
        points = self.curves.setdefault(data_path, curve).keyframe_points
        points.append(SimpleNamespace(interpolation="BEZIER"))

    def animation_data_clear(self) -> None:
        self.keys.clear()
        self.curves.clear()

    def copy(self) -> "Block":
        own_fields = ("keys", "own", "curves", "animation_data")
        twin = Block(
            **{name: value for name, value in vars(self).items() if name not in own_fields}
        )
        twin.keys.update({path: dict(keys) for path, keys in self.keys.items()})
        return twin

    def at(self, path: str, frame: int) -> object:
        """Return what an animated property is at a frame that may have a key."""
        if path in self.keys:
            return self.keys[path][frame]
        return self.value_of(path)


def camera_data(name: str) -> Block:
    return Block(
        name=name, users=2, lens=35.0, dof=SimpleNamespace(use_dof=False, focus_object="Cube")
    )


def camera_object(name: str, data: Block) -> Block:
    return Block(name=name, data=data, type="CAMERA", parent="rig", constraints=[SimpleNamespace()])


def fake_bpy(*cameras: Block, unit_m: float = 1.0) -> ModuleType:
    """Return a stand-in for bpy with what camera scripts need; cameras[0] is the scene's."""
    linked: list[Block] = []
    scene = SimpleNamespace(
        unit_settings=SimpleNamespace(scale_length=unit_m),
        camera=next(iter(cameras), None),
        collection=SimpleNamespace(objects=SimpleNamespace(link=linked.append)),
        render=SimpleNamespace(),
    )
    bpy = ModuleType("bpy")
    bpy.context = SimpleNamespace(scene=scene)
    cameras_by_name = {camera.name: camera for camera in cameras}
    bpy.data = SimpleNamespace(
        cameras=SimpleNamespace(new=camera_data),
        objects=SimpleNamespace(new=camera_object, get=cameras_by_name.get),
    )
    bpy.linked = linked
    return bpy


def run_script(text: str, bpy: ModuleType) -> Block:
    """Return the camera that the script leaves in the scene."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "bpy", bpy)
        exec(compile(text, "camera.py", "exec"), {"__name__": "__main__"})
    return bpy.context.scene.camera


ONE = FrameRange(1, 1)
OPENINGS = st.fixed_dictionaries(
    {
        "blades": st.sampled_from([0, 3, 5, 8]),
        "blade_rotation_deg": st.sampled_from([0.0, 20.0]),
        "cat_eye": st.sampled_from([0.0, 0.5]),
        "rim": st.sampled_from([0.0, -0.5]),
        "squeeze": st.sampled_from([1.0, 1.5]),
        "widest_f_stop": st.sampled_from([None, 1.0]),
        "aperture_image": st.sampled_from([None, OpeningImage("heart.png")]),
    }
)


@given(OPENINGS, OPENINGS)
def test_blender_script_resets_opening_of_previous_lens(before, after):
    """After any two lenses the camera has what it has after the second alone."""
    first, second = (
        blender_text(camera_of_shot(Shot(Lens(50.0, 2.0, 2.0, 36.0, **opening)), "c", ONE))
        for opening in (before, after)
    )
    scene = fake_bpy()
    run_script(first, scene)
    data = run_script(second, scene).data
    alone = run_script(second, fake_bpy()).data
    assert (data.dof, data.own) == (alone.dof, alone.own)
    assert data.dof.aperture_blades == after["blades"]


def test_blender_script_creates_camera_with_lens_keys_at_every_frame(tmp_path):
    camera = moving_camera()
    write_camera(tmp_path / "cam.py", camera)
    bpy = fake_bpy()
    camera_object = run_script((tmp_path / "cam.py").read_text(), bpy)
    assert bpy.linked == [camera_object] and camera_object.name == "hero cam"
    data = camera_object.data
    assert (data.sensor_fit, data.sensor_width, data.sensor_height) == ("HORIZONTAL", 36.0, 20.25)
    assert data.dof.use_dof and data.dof.focus_object is None
    assert (data.dof.aperture_fstop, data.dof.aperture_ratio) == (1.3, 1.8)
    assert set(data.keys) == {"lens", "dof.focus_distance"}
    curves = data.animation_data.action.fcurves
    assert {p.interpolation for curve in curves for p in curve.keyframe_points} == {"LINEAR"}
    assert (camera_object.parent, camera_object.constraints[0].mute) == (None, True)
    scene = bpy.context.scene
    assert (scene.frame_start, scene.frame_end) == (1001, 1008)
    assert (scene.render.fps, scene.render.fps_base) == (25, 1.0)
    for index, frame in enumerate(FRAMES):
        assert data.at("lens", frame) == camera.focal_length_mm[index]
        focus_m = min(camera.focus_distance_m[index], INFINITE_M)
        assert data.at("dof.focus_distance", frame) == focus_m


@given(SHOTS, st.sampled_from([1.0, 0.01]))
def test_blender_script_keys_match_lens_of_any_shot(shot, unit_m):
    data = run_script(blender_text(camera_of_shot(shot, "cam")), fake_bpy(unit_m=unit_m)).data
    for frame in FRAMES:
        lens = shot.lens_at(frame)
        assert data.at("lens", frame) == lens.focal_length_mm
        assert data.at("dof.aperture_fstop", frame) == lens.f_stop * unit_m
        assert data.at("dof.aperture_ratio", frame) == lens.squeeze
        focus_m = min(lens.focus_distance_m, INFINITE_M)
        keyed_focus = data.at("dof.focus_distance", frame)
        assert keyed_focus * unit_m == pytest.approx(focus_m, rel=1e-12)


@pytest.mark.parametrize("unit_m", [1.0, 0.01])
def test_blender_script_places_camera_as_plate_did_with_z_up(unit_m):
    camera_object = run_script(blender_text(moving_camera()), fake_bpy(unit_m=unit_m))
    assert camera_object.rotation_mode == "XYZ"
    for frame, eye in zip(FRAMES, dolly(), strict=True):
        rotation = xyz_rotation(camera_object.at("rotation_euler", frame))
        forward = np.subtract(TARGET, eye) / np.linalg.norm(np.subtract(TARGET, eye))
        assert rotation @ (0, 0, -1) == pytest.approx(z_up(forward), abs=1e-9)
        assert (rotation @ (1, 0, 0))[2] == pytest.approx(0, abs=1e-9)  # level
        position_m = np.multiply(camera_object.at("location", frame), unit_m)
        assert position_m == pytest.approx(z_up(eye), abs=1e-9)


def z_up(point):
    """Return a point of a world with y up, in one with z up."""
    x, y, z = point
    return (x, -z, y)


def xyz_rotation(angles) -> np.ndarray:
    """Return Blender's XYZ rotation in radians: about x first, z last."""
    rotation = np.eye(3)
    for axis, angle in enumerate(angles):
        c, s = math.cos(angle), math.sin(angle)
        i, j = (axis + 1) % 3, (axis + 2) % 3
        axis_rotation = np.eye(3)
        axis_rotation[[i, j, i, j], [i, j, j, i]] = c, c, -s, s
        rotation = axis_rotation @ rotation
    return rotation


def test_blender_script_keeps_placement_of_existing_scene_camera():
    """Old keys of its lens are gone, and another object with the same lens keeps them."""
    shared = camera_data("old")
    shared.keyframe_insert("lens", 7)
    shot_cam = Block(name="shot cam", type="CAMERA", data=shared, location=(1, 2, 3), parent="rig")
    shot_cam.keyframe_insert("location", 5)
    bpy = fake_bpy(shot_cam, camera_object("other", camera_data("other")))
    scene_camera = run_script(blender_text(moving_camera(world_to_camera=None)), bpy)
    assert scene_camera is shot_cam and bpy.linked == []
    assert (shot_cam.location, shot_cam.keys) == ((1, 2, 3), {"location": {5: (1, 2, 3)}})
    assert shot_cam.parent == "rig"
    assert list(shot_cam.data.keys["lens"]) == list(FRAMES)
    assert shared.keys == {"lens": {7: 35.0}}


def test_blender_script_uses_named_camera_as_scene_camera():
    first, other = (camera_object(name, camera_data(name)) for name in ("first", "other"))
    text = blender_text(moving_camera())
    assert (
        run_script(text.replace('CAMERA = ""', 'CAMERA = "other"'), fake_bpy(first, other)) is other
    )
    assert first.data.keys == {}
    with pytest.raises(SystemExit, match="no camera called 'none'"):
        run_script(text.replace('CAMERA = ""', 'CAMERA = "none"'), fake_bpy(first, other))


def test_blender_script_stores_nominal_f_stop_as_custom_property():
    camera = with_renderer_f_stop(moving_camera(lens_model=LensModel.PHOTOGRAPHIC))
    data = run_script(blender_text(camera), fake_bpy()).data
    for frame, f_stop in zip(FRAMES, camera.f_stop, strict=True):
        assert data.at("dof.aperture_fstop", frame) == f_stop
    assert data.own == {"nominal_f_stop": 1.3}


@pytest.mark.parametrize(
    ("rate", "fps", "base"), [(24.0, 24, 1.0), (23.976, 24, 1.001), (12.5, 12, 0.96), (0.5, 1, 2.0)]
)
def test_blender_script_sets_fps_and_fps_base(rate, fps, base):
    bpy = fake_bpy()
    run_script(blender_text(moving_camera(frames_per_second=rate)), bpy)
    render = bpy.context.scene.render
    assert (render.fps, render.fps_base) == (fps, pytest.approx(base, rel=1e-9))


def test_blender_script_without_focus_leaves_depth_of_field_unchanged():
    bare = moving_camera(focus_distance_m=None, f_stop=None, squeeze=None)
    scene_without = run_script(blender_text(bare), fake_bpy())
    assert scene_without.data.dof == SimpleNamespace(use_dof=False, focus_object="Cube")


@given(st.text())
def test_blender_script_accepts_any_camera_name(name):
    assert run_script(blender_text(moving_camera(name=name)), fake_bpy()).name == name
