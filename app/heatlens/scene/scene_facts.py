"""Describe the content of a scene as values that JSON can hold."""

from typing import Any

from heatlens.scene.first_shot import FirstShot
from heatlens.scene.scene import SceneCamera
from heatlens.scene.scene_bounds import bounds_m, object_names

Facts = dict[str, Any]


def scene_facts(first: FirstShot) -> Facts:
    """Return cameras, frames, objects and the size of the scene at the first frame.

    Lengths are metres or millimetres as their names say; x is to the right, y up. `frames` is None
    for a still scene.
    """
    scene, frames = first.scene, first.shot.frames
    low, high = bounds_m(scene, first.frame)
    return {
        "path": str(scene.path),
        "frames": None if frames is None else {"first": frames.first, "last": frames.last},
        "frames_per_second": first.shot.frames_per_second,
        "clips": list(scene.clips),
        "cameras": [_camera_facts(camera) for camera in scene.cameras],
        "lens_model": str(first.shot.lens.model),
        "objects": list(object_names(scene)),
        "triangles": scene.triangle_count,
        "lights": len(scene.lights),
        "sun": any(scene.daylight.sun),
        "size_m": [float(side) for side in high - low],
        "low_m": [float(value) for value in low],
        "notes": list(scene.notes),
    }


def _camera_facts(camera: SceneCamera) -> Facts:
    return {
        "name": camera.name,
        "focal_length_mm": camera.focal_length_mm,
        "sensor_width_mm": camera.sensor_width_mm,
        "sensor_width_assumed": camera.is_width_assumed,
        "moves": camera.track.is_moving,
    }
