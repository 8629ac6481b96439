"""Write a camera as USD: a UsdGeomCamera with a time sample at each frame of moving values.

UsdGeomCamera does not describe the opening, so attributes of heatlens do. The draft "Physical
Cameras for USD" of the OpenUSD proposals names two of the values, blades and squeeze, without a
prefix yet. These two are also custom data of the prim under the classes of that draft.

Focus at infinity is written as INFINITE_M, because renderers have no common value for it.
"""

import re
from collections.abc import Sequence

from heatlens.core.base.paths import read_file_bytes
from heatlens.core.base.stopping import temporary_folder
from heatlens.media.camera.placement import camera_to_world
from heatlens.media.camera.samples import OPENING_TRACKS, CameraSamples, finite_m
from heatlens.media.files.quiet import quiet_library
from heatlens.media.files.usd_library import UsdObject, usd_module

METERS_PER_UNIT = 0.01  # USD's default, with which focal lengths and apertures are in mm
# UsdGeomCamera has no attributes for these.
SQUEEZE = "heatlens:squeeze"
NOMINAL_F_STOP = "heatlens:nominalFStop"
LENS_MODEL = "heatlens:lensModel"
APERTURE_IMAGE = "heatlens:apertureImage"
OPENING = {
    name: f"heatlens:{words[0]}{re.sub(r'[^a-zA-Z]', '', words.title())[1:]}"
    for name, words in OPENING_TRACKS.items()
}

# Clipping range: 1 cm and 10 km, which is USD's default of 1 to 1e6 units in centimeters. In meters
# that default would cut off everything nearer than 1 m.
CLIPPING_M = (0.01, 1e4)

# Class and name in the draft proposal of each value that it defines.
DRAFT_KEYS = {
    "blades": "PhysicalCameraLens:shutter_blades",
    "squeeze": "PhysicalCameraLensModelPinhole:squeeze",
}

MM_ATTRIBUTES = {
    "focal_length_mm": "focalLength",
    "sensor_width_mm": "horizontalAperture",
    "sensor_height_mm": "verticalAperture",
}


def units_per_mm(meters_per_unit: float) -> float:
    """Return how many units of a lens attribute are 1 mm; USD's are tenths of a stage's unit."""
    return 1e-3 / meters_per_unit * 10


def usd_bytes(
    camera: CameraSamples, suffix: str, meters_per_unit: float = METERS_PER_UNIT
) -> bytes:
    """Return the file: text for .usda, binary for .usd and .usdc.

    Raises InputError if OpenUSD is not installed.
    """
    stage = _build_stage(camera, meters_per_unit)
    with temporary_folder() as folder, quiet_library():
        path = folder / f"camera{suffix}"
        stage.GetRootLayer().Export(str(path))
        return read_file_bytes(path)


def _build_stage(camera: CameraSamples, meters_per_unit: float) -> UsdObject:
    """Return a stage in memory that holds the camera as its default prim."""
    usd_package, geometry = usd_module("Usd"), usd_module("UsdGeom")
    stage = usd_package.Stage.CreateInMemory()
    geometry.SetStageMetersPerUnit(stage, meters_per_unit)
    geometry.SetStageUpAxis(stage, camera.up_axis.upper())
    stage.SetTimeCodesPerSecond(camera.frames_per_second)
    stage.SetFramesPerSecond(camera.frames_per_second)
    stage.SetStartTimeCode(camera.frames[0])
    stage.SetEndTimeCode(camera.frames[-1])
    prim = geometry.Camera.Define(stage, f"/{camera.identifier}")
    stage.SetDefaultPrim(prim.GetPrim())
    clipping = [distance_m / meters_per_unit for distance_m in CLIPPING_M]
    prim.GetClippingRangeAttr().Set(usd_module("Gf").Vec2f(clipping))
    _author_lens(prim, camera, meters_per_unit)
    _author_placement(prim, camera, meters_per_unit)
    return stage


def _author_lens(prim: UsdObject, camera: CameraSamples, meters_per_unit: float) -> None:
    """Write the lens tracks, the lens model and the path of the aperture image."""
    tracks = camera.lens_tracks
    file_units_per_mm = units_per_mm(meters_per_unit)
    for name, attribute in MM_ATTRIBUTES.items():
        if name in tracks:
            _author(
                prim.GetPrim().GetAttribute(attribute),
                camera,
                [length_mm * file_units_per_mm for length_mm in tracks[name]],
            )
    if "focus_distance_m" in tracks:
        distances = [finite_m(value) / meters_per_unit for value in tracks["focus_distance_m"]]
        _author(prim.GetFocusDistanceAttr(), camera, distances)
    if "f_stop" in tracks:
        _author(prim.GetFStopAttr(), camera, tracks["f_stop"])
    if "squeeze" in tracks:
        _author_float_attribute(prim, SQUEEZE, camera, tracks["squeeze"])
    if "nominal_f_stop" in tracks:
        _author_float_attribute(prim, NOMINAL_F_STOP, camera, tracks["nominal_f_stop"])
    for name, track in camera.opening.items():
        _author_float_attribute(prim, OPENING[name], camera, track)
    _author_draft_values(prim, camera)
    if camera.aperture_image is not None:
        string_type = usd_module("Sdf").ValueTypeNames.String
        prim.GetPrim().CreateAttribute(APERTURE_IMAGE, string_type).Set(camera.aperture_image.path)
    if camera.lens_model is not None:
        token_type = usd_module("Sdf").ValueTypeNames.Token
        prim.GetPrim().CreateAttribute(LENS_MODEL, token_type).Set(str(camera.lens_model))


def _author_draft_values(prim: UsdObject, camera: CameraSamples) -> None:
    """Write the values that the draft proposal names, from the first frame, unless they are 1."""
    tracks = camera.lens_tracks
    for name, key in DRAFT_KEYS.items():
        value = tracks[name][0] if name in tracks else 1.0
        if value > 1.0:
            stored_value = round(value) if name == "blades" else value
            prim.GetPrim().SetCustomDataByKey(key, stored_value)


def _author_float_attribute(
    prim: UsdObject, name: str, camera: CameraSamples, values: Sequence[float]
) -> None:
    """Create the attribute `name`, a float, and write its values."""
    value_type = usd_module("Sdf").ValueTypeNames.Float
    _author(prim.GetPrim().CreateAttribute(name, value_type), camera, values)


def _author_placement(prim: UsdObject, camera: CameraSamples, meters_per_unit: float) -> None:
    """Write the camera-to-world matrices; USD's points are rows, so they are transposed."""
    if camera.world_to_camera is None:
        return
    camera_matrices = camera_to_world(camera.world_to_camera, camera.up_axis, camera.up_axis)
    camera_matrices[:, :3, 3] /= meters_per_unit
    matrix = usd_module("Gf").Matrix4d
    _author(
        prim.AddTransformOp().GetAttr(),
        camera,
        [matrix(camera_matrix.T.tolist()) for camera_matrix in camera_matrices],
    )


def _author(attribute: UsdObject, camera: CameraSamples, values: Sequence[UsdObject]) -> None:
    """Write a value at each frame, or a single value for all times if it is constant.

    A single value can be edited in one place.
    """
    if all(value == values[0] for value in values):
        attribute.Set(values[0])
        return
    for frame, value in zip(camera.frames, values, strict=True):
        attribute.Set(value, frame)
