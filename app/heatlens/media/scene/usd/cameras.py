"""Cameras of USD: their poses over the frames, and their lenses."""

import math

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.camera_track import CameraTrack, Pose, PoseKey, pose_of
from heatlens.media.files import usd_library
from heatlens.media.files.usd_library import UsdObject, usd_module
from heatlens.media.scene.scene import SceneCamera
from heatlens.media.scene.usd.stage import STILL_FRAME, UsdStage

_INFINITE_M = 0.999e9  # a focus from here on is at infinity, which USD cannot express
# Field of Lens -> attribute of a camera.
_ATTRIBUTES = {
    "focal_length_mm": "focalLength",
    "f_stop": "fStop",
    "focus_distance_m": "focusDistance",
}
_WIDTH = "horizontalAperture"

Tracks = dict[str, tuple[float, ...]]


def is_camera(prim: UsdObject) -> bool:
    """Return True for a camera."""
    return bool(prim.IsA(usd_module("UsdGeom").Camera))


def find_animated_lens(prim: UsdObject) -> list[object]:
    """Return the attributes of a camera's lens that change over time."""
    attributes = [prim.GetAttribute(name) for name in _ATTRIBUTES.values()]
    return [attribute for attribute in attributes if attribute.GetNumTimeSamples() > 1]


def read_cameras(
    stage: UsdStage, prims: list[UsdObject], frames: FrameRange | None
) -> tuple[SceneCamera, ...]:
    """Return the cameras with a perspective view; raise InputError for an impossible lens."""
    cameras: list[SceneCamera] = []
    for prim in prims:
        if prim.GetAttribute("projection").Get() == "orthographic":
            stage.notes[f"{prim.GetPath()} is an orthographic camera, which has no lens."] = None
            continue
        names = [camera.name for camera in cameras]
        name = prim.GetName() if prim.GetName() not in names else str(prim.GetPath())
        cameras.append(_read_camera(stage, prim, name, frames))
    return tuple(cameras)


def _read_camera(
    stage: UsdStage, prim: UsdObject, name: str, frames: FrameRange | None
) -> SceneCamera:
    """Return a camera with its poses and its lens over the frames in which they change."""
    camera_frames = stage.frames_of([prim])
    frame_numbers = (
        [float(frame) for frame in camera_frames] if camera_frames else [float(STILL_FRAME)]
    )
    poses = (_read_pose(stage, prim, frame) for frame in frame_numbers)
    all_frames = tuple(frames) if frames and find_animated_lens(prim) else ()
    unit_mm = _lens_unit_mm(stage, prim, frame_numbers[0])
    tracks = _read_lens_tracks(stage, prim, all_frames or (int(frame_numbers[0]),), unit_mm)
    width_mm = _read_number(stage, prim, _WIDTH, frame_numbers[0]) * unit_mm
    focal_mm = tracks["focal_length_mm"]
    if not (0 < min(focal_mm) <= max(focal_mm) < math.inf and 0 < width_mm < math.inf):
        raise InputError(
            f"{stage.path}: the camera {prim.GetPath()} needs a focal length and a sensor above 0."
        )
    tracks = _drop_impossible(stage, prim, tracks)
    first_values = {field: track[0] for field, track in tracks.items()}
    return SceneCamera(
        name=name,
        track=CameraTrack(tuple(map(PoseKey, frame_numbers, poses))),
        focal_length_mm=focal_mm[0],
        sensor_width_mm=width_mm,
        f_stop=first_values.get("f_stop"),
        focus_distance_m=first_values.get("focus_distance_m"),
        lens_frames=all_frames,
        lens_tracks={field: track for field, track in tracks.items() if len(set(track)) > 1},
    )


def _lens_unit_mm(stage: UsdStage, prim: UsdObject, frame: float) -> float:
    """Return the millimeters in a unit of the lens; note a lens that is not in tenths of a unit."""
    usd_unit_mm = stage.meters_per_unit * 100
    focal, width = (
        _read_number(stage, prim, attribute, frame) for attribute in ("focalLength", _WIDTH)
    )
    unit_mm = usd_library.lens_unit_mm(stage.meters_per_unit, focal, width)
    if unit_mm != usd_unit_mm:
        note = usd_library.lens_unit_note(prim.GetPath(), stage.meters_per_unit, focal)
        stage.notes[note] = None
    return unit_mm


def _read_lens_tracks(
    stage: UsdStage, prim: UsdObject, frames: tuple[int, ...], unit_mm: float
) -> Tracks:
    """Return the lens at each frame: in millimeters, with the focus in meters."""
    units = {"focal_length_mm": unit_mm, "f_stop": 1.0, "focus_distance_m": stage.meters_per_unit}
    tracks = {
        field: tuple(_read_number(stage, prim, name, frame) * units[field] for frame in frames)
        for field, name in _ATTRIBUTES.items()
    }
    focus = (
        math.inf if distance_m >= _INFINITE_M else distance_m
        for distance_m in tracks["focus_distance_m"]
    )
    return tracks | {"focus_distance_m": tuple(focus)}


def _drop_impossible(stage: UsdStage, prim: UsdObject, tracks: Tracks) -> Tracks:
    """Return the tracks whose values are possible; note the others unless they are 0.

    In USD, an f-stop or a focus distance of 0 means that nothing is out of focus.
    """
    longest_m = max(tracks["focal_length_mm"]) / 1e3
    least_values = {"focal_length_mm": 0.0, "f_stop": 0.0, "focus_distance_m": longest_m}
    for field in ("f_stop", "focus_distance_m"):
        if any(tracks[field]) and min(tracks[field]) <= least_values[field]:
            words = field.removesuffix("_m").replace("_", " ")
            note = f"The {words} of {prim.GetPath()} is not possible for a lens, and is ignored."
            stage.notes[note] = None
    return {field: track for field, track in tracks.items() if min(track) > least_values[field]}


def _read_number(stage: UsdStage, prim: UsdObject, name: str, frame: float) -> float:
    """Return the number in an attribute of a prim at a frame."""
    return usd_library.checked_number(prim.GetAttribute(name).Get(frame), f"{stage.path}: {name}")


def _read_pose(stage: UsdStage, prim: UsdObject, frame: float) -> Pose:
    """Return the pose of a prim at a frame, without the scale and mirroring of its parents."""
    matrix = stage.world_matrices([prim], frame)[0]
    back, up = matrix[:3, 2], matrix[:3, 1]
    side = np.cross(up, back)
    if not np.linalg.norm(side) > 1e-30:
        raise InputError(f"{stage.path}: {prim.GetPath()} is scaled to zero.")
    matrix[:3, 0], matrix[:3, 1] = side, np.cross(back, side)
    return pose_of(matrix)
