"""Cameras in USD of other programs: what they tell is taken, what no camera has is refused."""

import math

import pytest
from pxr import Sdf, UsdGeom

from heatlens.core.base.errors import InputError
from heatlens.media.camera.usd_read import split_prim, usd_camera
from support.usd_cameras import stage_with


def test_a_camera_of_another_program(usd_path):
    """Under a moving, scaled parent, in centimetres, z up, sampled between frames, no blur set."""
    stage = stage_with(usd_path)
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
    found = usd_camera(str(usd_path))
    assert found.frames == (9, 10, 11, 12)
    assert found.focal_length_mm == (30.0, 32.5, 37.5, 40.0)
    assert (found.f_stop, found.focus_distance_m, found.squeeze) == (None, None, None)
    assert set(found.sensor_width_mm) == {20.955}
    where = [-matrix[0][3] for matrix in found.world_to_camera]
    assert where == pytest.approx([1.0, 1.0, 1.8, 2.0])
    assert [-matrix[1][3] for matrix in found.world_to_camera] == pytest.approx([1.0] * 4)


def test_a_mirrored_camera_gives_its_lens_alone(usd_path):
    stage = stage_with(usd_path, "/cam")
    UsdGeom.Xformable(stage.GetPrimAtPath("/cam")).AddScaleOp().Set((1, 1, -1))
    stage.GetRootLayer().Save()
    found = usd_camera(str(usd_path))
    assert found.world_to_camera is None and found.focal_length_mm == (50.0,)
    assert "shears or mirrors, and is left out" in found.notes[-1]


def test_one_of_several_cameras_is_named(usd_path):
    stage = stage_with(usd_path, "/world/a", "/world/b")
    UsdGeom.Camera(stage.GetPrimAtPath("/world/b")).GetFocalLengthAttr().Set(85.0)
    stage.GetRootLayer().Save()
    with pytest.raises(InputError, match=r"has 2 cameras: /world/a, /world/b. Name one, as in"):
        usd_camera(str(usd_path))
    found = usd_camera(f"{usd_path}:/world/b")
    assert found.focal_length_mm == (85.0,)
    assert found.notes == (f"{usd_path}: the camera is /world/b.",)
    with pytest.raises(InputError, match=r"has no camera /world/c; it has /world/a, /world/b"):
        usd_camera(f"{usd_path}:/world/c")


def test_a_name_with_colons_is_a_file_unless_a_prim_follows():
    for text in ("C:/shots/cam.usda", "a:b.usd", "cam.json", "shot.1001.exr"):
        assert str(split_prim(text)[0]) == text and split_prim(text)[1] is None
    assert [str(part) for part in split_prim("C:/s/cam.USDC:/w/c")] == ["C:/s/cam.USDC", "/w/c"]


def test_a_stage_without_a_camera_or_a_unit_is_refused(usd_path):
    stage = stage_with(usd_path)
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
        ("focalLength", -5.0, "/cam: Frame 1: the focal length of a camera cannot be -5"),
        (
            "horizontalAperture",
            math.nan,
            "/cam: Frame 1: the sensor width of a camera cannot be nan",
        ),
        ("fStop", math.inf, "/cam: Frame 1: the f-stop of a camera cannot be inf"),
    ],
)
def test_values_that_no_lens_has_are_refused(usd_path, attribute, value, sentence):
    stage = stage_with(usd_path, "/cam")
    stage.GetPrimAtPath("/cam").GetAttribute(attribute).Set(value)
    stage.GetRootLayer().Save()
    with pytest.raises(InputError, match=sentence):
        usd_camera(str(usd_path))


def test_a_camera_without_a_lens_is_refused(usd_path):
    stage = stage_with(usd_path, "/cam")
    stage.GetPrimAtPath("/cam").GetAttribute("projection").Set("orthographic")
    stage.GetRootLayer().Save()
    with pytest.raises(InputError, match="/cam: the camera is orthographic: it has no lens"):
        usd_camera(str(usd_path))


def test_a_value_that_is_no_number_is_refused(usd_path):
    stage = stage_with(usd_path, "/cam")
    kind = Sdf.ValueTypeNames.String
    stage.GetPrimAtPath("/cam").CreateAttribute("heatlens:squeeze", kind).Set("wide")
    stage.GetRootLayer().Save()
    with pytest.raises(
        InputError,
        match=r"cam.usda: /cam: heatlens:squeeze should be a number at frame 1, got 'wide'",
    ):
        usd_camera(str(usd_path))


@pytest.mark.parametrize("time", [2e9, -2e9])
def test_frames_that_cannot_be_are_refused(usd_path, time):
    stage = stage_with(usd_path, "/cam")
    attribute = UsdGeom.Camera(stage.GetPrimAtPath("/cam")).GetFocalLengthAttr()
    attribute.Set(50.0, 1)
    attribute.Set(60.0, time)
    stage.GetRootLayer().Save()
    with pytest.raises(InputError, match="at most nine digits"):
        usd_camera(str(usd_path))


@pytest.mark.parametrize("unit_m", [1.0, 0.3048, 0.1])
def test_a_lens_in_mm_on_a_stage_in_metres_is_read_as_mm(usd_path, unit_m):
    """A known fault of 3ds Max: by USD it would be a lens of metres, which no focus fits."""
    stage = stage_with(usd_path, "/cam")
    UsdGeom.SetStageMetersPerUnit(stage, unit_m)
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/cam"))
    camera.GetFocalLengthAttr().Set(75.0)
    camera.GetHorizontalApertureAttr().Set(36.0)
    camera.GetFocusDistanceAttr().Set(4.0)
    stage.GetRootLayer().Save()
    found = usd_camera(str(usd_path))
    assert found.focal_length_mm == (75.0,) and found.sensor_width_mm == (36.0,)
    assert found.focus_distance_m == pytest.approx((4.0 * unit_m,))
    assert any("seems to be in mm" in note and usd_path.name in note for note in found.notes)
