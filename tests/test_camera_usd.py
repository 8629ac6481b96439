"""Cameras in USD, against OpenUSD's own reading of them; damage is told in a sentence."""

import math
import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pxr import Gf, Sdf, Usd, UsdGeom

from cameras import FRAMES, SHOTS, TARGET, dolly, moving_camera
from heatlens.camera.camera_file import read_camera, write_camera
from heatlens.camera.from_shot import camera_of_shot
from heatlens.camera.samples import INFINITE_M, LENS_TRACKS
from heatlens.camera.usd_read import read_usd_camera, split_prim, usd_camera
from heatlens.errors import InputError

SUFFIXES = (".usda", ".usd", ".usdc")
UNITS_M = (1.0, 0.01, 0.3048, 0.0254)
STAGE_TENTHS_OF_MM = {1.0: 0.01, 0.01: 1.0, 0.3048: 1 / 30.48, 0.0254: 1 / 2.54}


@pytest.fixture
def path(tmp_path):
    return tmp_path / "cam.usda"


def assert_same(found, expected):
    """Every track and the placement, within what float32 can hold."""
    for name in LENS_TRACKS:
        track = getattr(expected, name)
        assert getattr(found, name) == (track and pytest.approx(track, rel=1e-6))
    assert found.frames_per_second == expected.frames_per_second
    assert np.shape(found.world_to_camera) == np.shape(expected.world_to_camera)
    if expected.world_to_camera is not None:
        placement = np.array(expected.world_to_camera)
        assert np.array(found.world_to_camera) == pytest.approx(placement, abs=1e-9)


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("unit_m", UNITS_M)
def test_what_is_written_is_read_again_in_every_unit(tmp_path, suffix, unit_m):
    path, camera = tmp_path / f"cam{suffix}", moving_camera()
    write_camera(path, camera, unit_m)
    found = usd_camera(str(path))
    assert_same(found, camera)
    assert (found.frames, found.name) == (camera.frames, "hero_cam")


@pytest.mark.parametrize("unit_m", UNITS_M)
def test_openusd_sees_the_camera_that_was_meant(path, unit_m):
    camera = moving_camera()
    write_camera(path, camera, unit_m)
    stage = Usd.Stage.Open(str(path))
    assert UsdGeom.GetStageMetersPerUnit(stage) == unit_m
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (1001, 1008)
    assert stage.GetTimeCodesPerSecond() == 25.0
    prim = UsdGeom.Camera(stage.GetDefaultPrim())
    for index, (frame, eye) in enumerate(zip(FRAMES, dolly(), strict=True)):
        seen = prim.GetCamera(frame)
        tenths = STAGE_TENTHS_OF_MM[unit_m]
        assert seen.focalLength == pytest.approx(camera.focal_length_mm[index] * tenths, rel=1e-6)
        assert seen.horizontalAperture == pytest.approx(36.0 * tenths, rel=1e-6)
        assert seen.verticalAperture == pytest.approx(20.25 * tenths, rel=1e-6)
        assert seen.fStop == pytest.approx(1.3, rel=1e-6)
        assert tuple(seen.frustum.position * unit_m) == pytest.approx(eye, abs=1e-9)
        forward = np.subtract(TARGET, eye) / np.linalg.norm(np.subtract(TARGET, eye))
        assert tuple(seen.frustum.ComputeViewDirection()) == pytest.approx(forward, abs=1e-9)
        focus_m = min(camera.focus_distance_m[index], INFINITE_M)
        assert seen.focusDistance * unit_m == pytest.approx(focus_m, rel=1e-6)
    # The field of view has no unit: it tells whether lens and film back are in the same one.
    angle = 2 * math.degrees(math.atan(18 / 50))
    assert prim.GetCamera(1001).GetFieldOfView(Gf.Camera.FOVHorizontal) == pytest.approx(angle)


def test_a_metre_stage_counts_lenses_in_tenths_of_a_metre(path):
    """25 mm are 0.25 there, as the schema's documentation has it; the focus is in metres."""
    write_camera(path, moving_camera(focal_length_mm=(25.0,) * 8, focus_distance_m=(3.0,) * 8), 1.0)
    stage = Usd.Stage.Open(str(path))
    prim = UsdGeom.Camera(stage.GetDefaultPrim())
    assert prim.GetFocalLengthAttr().Get() == 0.25
    assert prim.GetFocusDistanceAttr().Get() == 3.0


def test_what_stands_still_has_no_time_samples(path):
    write_camera(path, moving_camera())
    stage = Usd.Stage.Open(str(path))
    prim = stage.GetDefaultPrim()
    sampled = {a.GetName() for a in prim.GetAuthoredAttributes() if a.GetNumTimeSamples()}
    assert sampled == {"focalLength", "focusDistance", "xformOp:transform"}
    assert prim.GetAttribute("focusDistance").GetTimeSamples() == list(FRAMES)


def test_what_is_not_told_is_not_written(path):
    bare = moving_camera(
        f_stop=None, focus_distance_m=None, squeeze=None, world_to_camera=None, up_axis="z"
    )
    write_camera(path, bare)
    stage = Usd.Stage.Open(str(path))
    names = {attribute.GetName() for attribute in stage.GetDefaultPrim().GetAuthoredAttributes()}
    assert names == {"focalLength", "horizontalAperture", "verticalAperture"}
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    assert_same(usd_camera(str(path)), bare)
    assert usd_camera(str(path)).up_axis == "z"


@settings(max_examples=40, deadline=None)
@given(SHOTS, st.sampled_from(SUFFIXES), st.sampled_from(UNITS_M))
def test_the_camera_of_any_shot_is_read_again(tmp_path_factory, shot, suffix, unit_m):
    path = tmp_path_factory.mktemp("usd") / f"cam{suffix}"
    camera = camera_of_shot(shot, "cam")
    write_camera(path, camera, unit_m)
    found = usd_camera(str(path))
    still = all(len(set(track)) == 1 for track in camera.lens_tracks.values())
    assert found.frames == ((1,) if still else camera.frames)
    if set(camera.squeeze) == {1.0}:
        camera = replace(camera, squeeze=None)
    tracks = {name: track[: len(found.frames)] for name, track in camera.lens_tracks.items()}
    assert_same(found, replace(camera, frames=found.frames, **tracks))


def stage_with(path, *prims: str) -> Usd.Stage:
    stage = Usd.Stage.CreateNew(str(path))
    for prim in prims:
        UsdGeom.Camera.Define(stage, prim)
    return stage


def test_a_camera_of_another_program(path):
    """Under a moving, scaled parent, in centimetres, z up, sampled between frames, no blur set."""
    stage = stage_with(path)
    UsdGeom.SetStageUpAxis(stage, "Z")
    rig = UsdGeom.Xform.Define(stage, "/rig")
    rig.AddTranslateOp().Set((100, 0, 0), 10)
    rig.GetPrim().GetAttribute("xformOp:translate").Set((200, 0, 0), 11.25)
    rig.AddScaleOp().Set((2, 2, 2))
    camera = UsdGeom.Camera.Define(stage, "/rig/cam")
    camera.AddTranslateOp().Set((0, 50, 0))
    camera.GetFocalLengthAttr().Set(30.0, 9.5)
    camera.GetFocalLengthAttr().Set(40.0, 11.5)
    stage.GetRootLayer().Save()
    found = usd_camera(str(path))
    assert found.frames == (9, 10, 11, 12)
    assert found.focal_length_mm == (30.0, 32.5, 37.5, 40.0)
    assert (found.f_stop, found.focus_distance_m, found.squeeze) == (None, None, None)
    assert set(found.sensor_width_mm) == {20.955}
    where = [-matrix[0][3] for matrix in found.world_to_camera]
    assert where == pytest.approx([1.0, 1.0, 1.8, 2.0])
    assert [-matrix[1][3] for matrix in found.world_to_camera] == pytest.approx([1.0] * 4)


def test_a_mirrored_camera_gives_its_lens_alone(path):
    stage = stage_with(path, "/cam")
    UsdGeom.Xformable(stage.GetPrimAtPath("/cam")).AddScaleOp().Set((1, 1, -1))
    stage.GetRootLayer().Save()
    found = usd_camera(str(path))
    assert found.world_to_camera is None and found.focal_length_mm == (50.0,)
    assert "shears or mirrors: it is left out" in found.notes[-1]


def test_one_of_several_cameras_is_named(path):
    stage = stage_with(path, "/world/a", "/world/b")
    UsdGeom.Camera(stage.GetPrimAtPath("/world/b")).GetFocalLengthAttr().Set(85.0)
    stage.GetRootLayer().Save()
    with pytest.raises(InputError, match=r"holds 2 cameras: /world/a, /world/b. Name one, as in"):
        usd_camera(str(path))
    found = usd_camera(f"{path}:/world/b")
    assert found.focal_length_mm == (85.0,)
    assert found.notes == (f"{path}: the camera is /world/b.",)
    with pytest.raises(InputError, match=r"holds no camera /world/c; there is /world/a, /world/b"):
        usd_camera(f"{path}:/world/c")


def test_a_name_with_colons_is_a_file_unless_a_prim_follows():
    for text in ("C:/shots/cam.usda", "a:b.usd", "cam.json", "shot.1001.exr"):
        assert str(split_prim(text)[0]) == text and split_prim(text)[1] is None
    assert [str(part) for part in split_prim("C:/s/cam.USDC:/w/c")] == ["C:/s/cam.USDC", "/w/c"]


def test_a_stage_without_a_camera_or_a_unit_is_refused(path):
    stage = stage_with(path)
    stage.GetRootLayer().Save()
    with pytest.raises(InputError, match="holds no camera"):
        usd_camera(str(path))
    UsdGeom.Camera.Define(stage, "/cam")
    UsdGeom.SetStageMetersPerUnit(stage, 0.0)
    stage.GetRootLayer().Save()
    with pytest.raises(InputError, match="has 0 metres per unit"):
        usd_camera(str(path))


@pytest.mark.parametrize(
    ("attribute", "value", "sentence"),
    [
        ("focalLength", -5.0, "/cam: Frame 1: no camera has a focal length of -5"),
        ("horizontalAperture", math.nan, "/cam: Frame 1: no camera has a sensor width of nan"),
        ("fStop", math.inf, "/cam: Frame 1: no camera has a f-stop of inf"),
    ],
)
def test_values_that_no_lens_has_are_refused(path, attribute, value, sentence):
    stage = stage_with(path, "/cam")
    stage.GetPrimAtPath("/cam").GetAttribute(attribute).Set(value)
    stage.GetRootLayer().Save()
    with pytest.raises(InputError, match=sentence):
        usd_camera(str(path))


def test_a_camera_without_a_lens_is_refused(path):
    stage = stage_with(path, "/cam")
    stage.GetPrimAtPath("/cam").GetAttribute("projection").Set("orthographic")
    stage.GetRootLayer().Save()
    with pytest.raises(InputError, match="/cam: the camera is orthographic: it has no lens"):
        usd_camera(str(path))


def test_a_value_that_is_no_number_is_refused(path):
    stage = stage_with(path, "/cam")
    kind = Sdf.ValueTypeNames.String
    stage.GetPrimAtPath("/cam").CreateAttribute("heatlens:squeeze", kind).Set("wide")
    stage.GetRootLayer().Save()
    with pytest.raises(
        InputError, match=r"cam.usda: /cam: heatlens:squeeze has no number at frame 1, but 'wide'"
    ):
        usd_camera(str(path))


@pytest.mark.parametrize("time", [2e9, -2e9])
def test_frames_that_cannot_be_are_refused(path, time):
    stage = stage_with(path, "/cam")
    attribute = UsdGeom.Camera(stage.GetPrimAtPath("/cam")).GetFocalLengthAttr()
    attribute.Set(50.0, 1)
    attribute.Set(60.0, time)
    stage.GetRootLayer().Save()
    with pytest.raises(InputError, match="at most nine digits"):
        usd_camera(str(path))


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("content", [b"", b"\x89PNG\r\n\x1a\n", b'#usda 1.0\ndef Camera "a" {'])
def test_what_is_no_usd_is_told_in_a_sentence(tmp_path, capfd, suffix, content):
    path = tmp_path / f"cam{suffix}"
    path.write_bytes(content)
    with pytest.raises(InputError, match="cannot be read: it is damaged or no USD file") as refusal:
        usd_camera(str(path))
    assert len(str(refusal.value).splitlines()) == 1
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("suffix", [".usda", ".usdc"])
def test_a_file_cut_short_is_told_in_a_sentence(tmp_path, suffix):
    path = tmp_path / f"cam{suffix}"
    write_camera(path, moving_camera())
    whole = path.read_bytes()
    for length in range(0, len(whole) - 2, len(whole) // 12):
        path.write_bytes(whole[:length])
        with pytest.raises(InputError, match="it is damaged or no USD file"):
            usd_camera(str(path))


def test_a_missing_file_is_told():
    with pytest.raises(InputError, match=r"none.usda is not there, or is no file"):
        usd_camera("none.usda")


def test_reading_is_safe_from_what_ends_openusd(path):
    """The camera, its errors, and a process that ends all come back as they should."""
    write_camera(path, moving_camera())
    assert read_camera(str(path)) == usd_camera(str(path))
    with pytest.raises(InputError, match="holds no camera /b; there is /hero_cam"):
        read_usd_camera(f"{path}:/b")


@pytest.mark.parametrize("code", [3, -11])
def test_a_file_that_ends_openusd_is_told(path, monkeypatch, code):
    """In the place of Python a program that ends as a crash does."""
    program = path.with_name("python")
    program.write_text(f"#!/bin/sh\n{'kill -SEGV $$' if code < 0 else f'exit {code}'}\n")
    program.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(program))
    with pytest.raises(InputError, match=r"cam.usda cannot be read: it is damaged in a way that"):
        read_usd_camera(f"{path}:/cam")


def test_our_own_mistakes_are_not_the_files(path, monkeypatch):
    monkeypatch.setattr("heatlens.image.apart.__spec__.name", "heatlens.no_such_module")
    with pytest.raises(RuntimeError, match=r"No module named .*no_such_module"):
        read_usd_camera(str(path))


def test_files_beside_the_stage_are_not_run(path, monkeypatch):
    write_camera(path, moving_camera())
    path.with_name("pickle.py").write_text("raise SystemExit(1)")
    monkeypatch.chdir(path.parent)
    assert read_usd_camera(path.name).frames == tuple(FRAMES)


def test_without_openusd_the_command_that_fixes_it_is_told(path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pxr.Usd", None)
    for use in (lambda: write_camera(path, moving_camera()), lambda: usd_camera(str(path))):
        with pytest.raises(InputError, match="Install it with: pip install usd-core"):
            use()
    assert not path.exists()
