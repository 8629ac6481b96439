"""Test USD cameras of other programs: known values are read, impossible ones are rejected."""

import math

import pytest
from pxr import Sdf, UsdGeom

from heatlens.core.base.errors import InputError
from heatlens.media.camera.usd_read import split_prim, usd_camera
from support.usd_cameras import write_camera_stage


def test_usd_camera_reads_foreign_stage_with_scaled_moving_parent(usd_path):
    """The stage is z up, in centimeters, sampled between frames, and sets no f-stop or focus."""
    stage = write_camera_stage(usd_path)
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
    camera_samples = usd_camera(str(usd_path))
    assert camera_samples.frames == (9, 10, 11, 12)
    assert camera_samples.focal_length_mm == (30.0, 32.5, 37.5, 40.0)
    assert (camera_samples.f_stop, camera_samples.focus_distance_m, camera_samples.squeeze) == (
        None,
        None,
        None,
    )
    assert set(camera_samples.sensor_width_mm) == {20.955}
    x_m = [-matrix[0][3] for matrix in camera_samples.world_to_camera]
    assert x_m == pytest.approx([1.0, 1.0, 1.8, 2.0])
    assert [-matrix[1][3] for matrix in camera_samples.world_to_camera] == pytest.approx([1.0] * 4)


def test_usd_camera_that_is_mirrored_gives_lens_without_placement(usd_path):
    stage = write_camera_stage(usd_path, "/cam")
    UsdGeom.Xformable(stage.GetPrimAtPath("/cam")).AddScaleOp().Set((1, 1, -1))
    stage.GetRootLayer().Save()
    camera_samples = usd_camera(str(usd_path))
    assert camera_samples.world_to_camera is None and camera_samples.focal_length_mm == (50.0,)
    assert "shears or mirrors, and is left out" in camera_samples.notes[-1]


def test_usd_camera_of_several_must_be_named_by_prim(usd_path):
    stage = write_camera_stage(usd_path, "/world/a", "/world/b")
    UsdGeom.Camera(stage.GetPrimAtPath("/world/b")).GetFocalLengthAttr().Set(85.0)
    stage.GetRootLayer().Save()
    with pytest.raises(InputError, match=r"has 2 cameras: /world/a, /world/b. Name one, as in"):
        usd_camera(str(usd_path))
    camera_samples = usd_camera(f"{usd_path}:/world/b")
    assert camera_samples.focal_length_mm == (85.0,)
    assert camera_samples.notes == (f"{usd_path}: the camera is /world/b.",)
    with pytest.raises(InputError, match=r"has no camera /world/c; it has /world/a, /world/b"):
        usd_camera(f"{usd_path}:/world/c")


def test_split_prim_splits_at_colon_only_before_a_prim_path():
    for text in ("C:/shots/cam.usda", "a:b.usd", "cam.json", "shot.1001.exr"):
        assert str(split_prim(text)[0]) == text and split_prim(text)[1] is None
    assert [str(part) for part in split_prim("C:/s/cam.USDC:/w/c")] == ["C:/s/cam.USDC", "/w/c"]


def test_usd_camera_rejects_stage_without_camera_or_unit(usd_path):
    stage = write_camera_stage(usd_path)
    stage.GetRootLayer().Save()
    with pytest.raises(InputError, match="has no camera"):
        usd_camera(str(usd_path))
    UsdGeom.Camera.Define(stage, "/cam")
    UsdGeom.SetStageMetersPerUnit(stage, 0.0)
    stage.GetRootLayer().Save()
    with pytest.raises(InputError, match="has 0 metres per unit"):
        usd_camera(str(usd_path))


@pytest.mark.parametrize(
    ("attribute", "value", "sentence"),
    [
        ("focalLength", -5.0, "/cam: Frame 1: the focal length of a camera must be .*, got -5"),
        (
            "horizontalAperture",
            math.nan,
            "/cam: Frame 1: the sensor width of a camera must be .*, got nan",
        ),
        ("fStop", math.inf, "/cam: Frame 1: the f-stop of a camera must be .*, got inf"),
    ],
)
def test_usd_camera_rejects_impossible_lens_values(usd_path, attribute, value, sentence):
    stage = write_camera_stage(usd_path, "/cam")
    stage.GetPrimAtPath("/cam").GetAttribute(attribute).Set(value)
    stage.GetRootLayer().Save()
    with pytest.raises(InputError, match=sentence):
        usd_camera(str(usd_path))


def test_usd_camera_rejects_orthographic_camera(usd_path):
    stage = write_camera_stage(usd_path, "/cam")
    stage.GetPrimAtPath("/cam").GetAttribute("projection").Set("orthographic")
    stage.GetRootLayer().Save()
    with pytest.raises(InputError, match="/cam: the camera is orthographic, so it has no lens"):
        usd_camera(str(usd_path))


def test_usd_camera_rejects_attribute_that_is_no_number(usd_path):
    stage = write_camera_stage(usd_path, "/cam")
    kind = Sdf.ValueTypeNames.String
    stage.GetPrimAtPath("/cam").CreateAttribute("heatlens:squeeze", kind).Set("wide")
    stage.GetRootLayer().Save()
    with pytest.raises(
        InputError,
        match=r"cam.usda: /cam: heatlens:squeeze should be a number at frame 1, got 'wide'",
    ):
        usd_camera(str(usd_path))


@pytest.mark.parametrize("time", [2e9, -2e9])
def test_usd_camera_rejects_frames_beyond_nine_digits(usd_path, time):
    stage = write_camera_stage(usd_path, "/cam")
    attribute = UsdGeom.Camera(stage.GetPrimAtPath("/cam")).GetFocalLengthAttr()
    attribute.Set(50.0, 1)
    attribute.Set(60.0, time)
    stage.GetRootLayer().Save()
    with pytest.raises(InputError, match="at most nine digits"):
        usd_camera(str(usd_path))


@pytest.mark.parametrize("unit_m", [1.0, 0.3048, 0.1])
def test_usd_camera_reads_lens_in_mm_on_stage_in_meters(usd_path, unit_m):
    """3ds Max is known to write mm on such a stage; read as USD, the lens would be meters long."""
    stage = write_camera_stage(usd_path, "/cam")
    UsdGeom.SetStageMetersPerUnit(stage, unit_m)
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/cam"))
    camera.GetFocalLengthAttr().Set(75.0)
    camera.GetHorizontalApertureAttr().Set(36.0)
    camera.GetFocusDistanceAttr().Set(4.0)
    stage.GetRootLayer().Save()
    camera_samples = usd_camera(str(usd_path))
    assert camera_samples.focal_length_mm == (75.0,) and camera_samples.sensor_width_mm == (36.0,)
    assert camera_samples.focus_distance_m == pytest.approx((4.0 * unit_m,))
    assert any(
        "seems to be in mm" in note and usd_path.name in note for note in camera_samples.notes
    )
