"""Compare cameras that heatlens writes in USD with what OpenUSD itself reads."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pxr import Gf, Usd, UsdGeom

from heatlens.media.camera.camera_file import write_camera
from heatlens.media.camera.samples import INFINITE_M, LENS_TRACKS, fields_of
from heatlens.media.camera.usd_read import usd_camera
from heatlens.render.source.named import camera_of_shot
from support.cameras import FRAMES, SHOTS, TARGET, dolly, moving_camera
from support.usd_cameras import SUFFIXES

UNITS_M = (1.0, 0.01, 0.3048, 0.0254)
STAGE_TENTHS_OF_MM = {1.0: 0.01, 0.01: 1.0, 0.3048: 1 / 30.48, 0.0254: 1 / 2.54}


def assert_same_camera(found, expected):
    """Check every track and the placement, within the precision of float32."""
    for name in LENS_TRACKS:
        track = expected.lens_tracks.get(name)
        assert found.lens_tracks.get(name) == (track and pytest.approx(track, rel=1e-6))
    assert found.frames_per_second == expected.frames_per_second
    assert np.shape(found.world_to_camera) == np.shape(expected.world_to_camera)
    if expected.world_to_camera is not None:
        placement = np.array(expected.world_to_camera)
        assert np.array(found.world_to_camera) == pytest.approx(placement, abs=1e-9)


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("unit_m", UNITS_M)
def test_usd_camera_reads_back_written_camera_in_every_unit(tmp_path, suffix, unit_m):
    path, camera = tmp_path / f"cam{suffix}", moving_camera()
    write_camera(path, camera, unit_m)
    read_back = usd_camera(str(path))
    assert_same_camera(read_back, camera)
    assert (read_back.frames, read_back.name) == (camera.frames, "hero_cam")


@pytest.mark.parametrize("unit_m", UNITS_M)
def test_openusd_reads_written_camera_with_correct_lens_and_placement(usd_path, unit_m):
    camera = moving_camera()
    write_camera(usd_path, camera, unit_m)
    stage = Usd.Stage.Open(str(usd_path))
    assert UsdGeom.GetStageMetersPerUnit(stage) == unit_m
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (1001, 1008)
    assert stage.GetTimeCodesPerSecond() == 25.0
    prim = UsdGeom.Camera(stage.GetDefaultPrim())
    for index, (frame, eye) in enumerate(zip(FRAMES, dolly(), strict=True)):
        gf_camera = prim.GetCamera(frame)
        tenths = STAGE_TENTHS_OF_MM[unit_m]
        assert gf_camera.focalLength == pytest.approx(
            camera.focal_length_mm[index] * tenths, rel=1e-6
        )
        assert gf_camera.horizontalAperture == pytest.approx(36.0 * tenths, rel=1e-6)
        assert gf_camera.verticalAperture == pytest.approx(20.25 * tenths, rel=1e-6)
        assert gf_camera.fStop == pytest.approx(1.3, rel=1e-6)
        assert tuple(gf_camera.frustum.position * unit_m) == pytest.approx(eye, abs=1e-9)
        forward = np.subtract(TARGET, eye) / np.linalg.norm(np.subtract(TARGET, eye))
        assert tuple(gf_camera.frustum.ComputeViewDirection()) == pytest.approx(forward, abs=1e-9)
        focus_m = min(camera.focus_distance_m[index], INFINITE_M)
        assert gf_camera.focusDistance * unit_m == pytest.approx(focus_m, rel=1e-6)
    # The field of view has no unit: it tells whether lens and film back are in the same one.
    angle = 2 * math.degrees(math.atan(18 / 50))
    assert prim.GetCamera(1001).GetFieldOfView(Gf.Camera.FOVHorizontal) == pytest.approx(angle)


def test_usd_stage_in_meters_stores_lens_in_tenths_of_a_meter(usd_path):
    """25 mm are stored as 0.25, as the schema's documentation says; the focus is in meters."""
    write_camera(
        usd_path, moving_camera(focal_length_mm=(25.0,) * 8, focus_distance_m=(3.0,) * 8), 1.0
    )
    stage = Usd.Stage.Open(str(usd_path))
    prim = UsdGeom.Camera(stage.GetDefaultPrim())
    assert prim.GetFocalLengthAttr().Get() == 0.25
    assert prim.GetFocusDistanceAttr().Get() == 3.0


def test_usd_camera_writes_time_samples_only_for_moving_values(usd_path):
    write_camera(usd_path, moving_camera())
    stage = Usd.Stage.Open(str(usd_path))
    prim = stage.GetDefaultPrim()
    sampled = {a.GetName() for a in prim.GetAuthoredAttributes() if a.GetNumTimeSamples()}
    assert sampled == {"focalLength", "focusDistance", "xformOp:transform"}
    assert prim.GetAttribute("focusDistance").GetTimeSamples() == list(FRAMES)


def test_usd_camera_omits_unknown_values(usd_path):
    bare = moving_camera(
        f_stop=None, focus_distance_m=None, squeeze=None, world_to_camera=None, up_axis="z"
    )
    write_camera(usd_path, bare)
    stage = Usd.Stage.Open(str(usd_path))
    names = {attribute.GetName() for attribute in stage.GetDefaultPrim().GetAuthoredAttributes()}
    assert names == {"clippingRange", "focalLength", "horizontalAperture", "verticalAperture"}
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    assert_same_camera(usd_camera(str(usd_path)), bare)
    assert usd_camera(str(usd_path)).up_axis == "z"


@settings(max_examples=40, deadline=None)
@given(SHOTS, st.sampled_from(SUFFIXES), st.sampled_from(UNITS_M))
def test_usd_camera_of_any_shot_reads_back(tmp_path_factory, shot, suffix, unit_m):
    path = tmp_path_factory.mktemp("usd") / f"cam{suffix}"
    camera = camera_of_shot(shot, "cam")
    write_camera(path, camera, unit_m)
    read_back = usd_camera(str(path))
    is_constant = all(len(set(track)) == 1 for track in camera.lens_tracks.values())
    assert read_back.frames == ((1,) if is_constant else camera.frames)
    tracks = {name: track[: len(read_back.frames)] for name, track in camera.lens_tracks.items()}
    assert_same_camera(read_back, replace(camera, frames=read_back.frames, **fields_of(tracks)))
