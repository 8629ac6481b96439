"""Cameras of USD: their poses over the frames, and their lenses."""

import math

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.framing import CameraTrack, Pose, PoseKey, pose_of
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
    return bool(prim.IsA(usd_module("UsdGeom").Camera))


def changing_lens(prim: UsdObject) -> list[object]:
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
        cameras.append(_camera(stage, prim, name, frames))
    return tuple(cameras)


def _camera(stage: UsdStage, prim: UsdObject, name: str, frames: FrameRange | None) -> SceneCamera:
    own = stage.frames_of([prim])
    at = [float(frame) for frame in own] if own else [float(STILL_FRAME)]
    poses = (_pose(stage, prim, frame) for frame in at)
    all_frames = tuple(frames) if frames and changing_lens(prim) else ()
    mm = _lens_unit_mm(stage, prim, at[0])
    tracks = _tracks(stage, prim, all_frames or (int(at[0]),), mm)
    width_mm = _number(stage, prim, _WIDTH, at[0]) * mm
    focal_mm = tracks["focal_length_mm"]
    if not (0 < min(focal_mm) <= max(focal_mm) < math.inf and 0 < width_mm < math.inf):
        raise InputError(f"{stage.path}: {prim.GetPath()} has an impossible lens.")
    tracks = _possible(stage, prim, tracks)
    first = {field: track[0] for field, track in tracks.items()}
    return SceneCamera(
        name,
        CameraTrack(tuple(map(PoseKey, at, poses))),
        focal_mm[0],
        width_mm,
        first.get("f_stop"),
        first.get("focus_distance_m"),
        all_frames,
        {field: track for field, track in tracks.items() if len(set(track)) > 1},
    )


def _lens_unit_mm(stage: UsdStage, prim: UsdObject, frame: float) -> float:
    """Return how many mm one unit of the lens is; note a lens that is not in tenths of a unit."""
    by_usd = stage.meters_per_unit * 100
    focal, width = (_number(stage, prim, it, frame) for it in ("focalLength", _WIDTH))
    mm = usd_library.lens_unit_mm(stage.meters_per_unit, focal, width)
    if mm != by_usd:
        note = usd_library.lens_unit_note(prim.GetPath(), stage.meters_per_unit, focal)
        stage.notes[note] = None
    return mm


def _tracks(stage: UsdStage, prim: UsdObject, frames: tuple[int, ...], mm: float) -> Tracks:
    """Return the lens at each frame: millimetres, and metres for the focus."""
    units = {"focal_length_mm": mm, "f_stop": 1.0, "focus_distance_m": stage.meters_per_unit}
    tracks = {
        field: tuple(_number(stage, prim, name, frame) * units[field] for frame in frames)
        for field, name in _ATTRIBUTES.items()
    }
    focus = (math.inf if m >= _INFINITE_M else m for m in tracks["focus_distance_m"])
    return tracks | {"focus_distance_m": tuple(focus)}


def _possible(stage: UsdStage, prim: UsdObject, tracks: Tracks) -> Tracks:
    """Return the tracks with possible values; in USD, 0 means that nothing is out of focus."""
    longest_m = max(tracks["focal_length_mm"]) / 1e3
    least = {"focal_length_mm": 0.0, "f_stop": 0.0, "focus_distance_m": longest_m}
    for field in ("f_stop", "focus_distance_m"):
        if any(tracks[field]) and min(tracks[field]) <= least[field]:
            words = field.removesuffix("_m").replace("_", " ")
            note = f"The {words} of {prim.GetPath()} is not possible for a lens, and is ignored."
            stage.notes[note] = None
    return {field: track for field, track in tracks.items() if min(track) > least[field]}


def _number(stage: UsdStage, prim: UsdObject, name: str, frame: float) -> float:
    return usd_library.number(prim.GetAttribute(name).Get(frame), f"{stage.path}: {name}")


def _pose(stage: UsdStage, prim: UsdObject, frame: float) -> Pose:
    """Return the pose of a prim without its parents' scale, upright if they mirror it."""
    matrix = stage.places([prim], frame)[0]
    back, up = matrix[:3, 2], matrix[:3, 1]
    side = np.cross(up, back)
    if not np.linalg.norm(side) > 1e-30:
        raise InputError(f"{stage.path}: {prim.GetPath()} is scaled to zero.")
    matrix[:3, 0], matrix[:3, 1] = side, np.cross(back, side)
    return pose_of(matrix)
