"""View a shot through a camera of its scene, with the lens values that the file has."""

from dataclasses import replace
from typing import Any

from heatlens.model.framing import Framing
from heatlens.model.linear_keys import linear_keys
from heatlens.model.shot import LensParameter, Shot
from heatlens.scene.scene import SceneCamera

ANGLE = ("focal_length_mm", "sensor_width_mm")
OPENING = ("f_stop", "focus_distance_m")


def through_camera(shot: Shot, camera: SceneCamera) -> Shot:
    """Return the shot with the position, motion, lens and keys of a camera.

    Keys are replaced for values that the file has. A camera of which only the angle of view is
    known keeps it on the sensor of the shot.
    """
    framing = replace(shot.framing or Framing(), camera=camera.name, track=None)
    values, tracks = lens_values(camera), dict(camera.lens_tracks)
    if camera.is_width_assumed:
        scale = shot.lens.sensor_width_mm / camera.sensor_width_mm
        values["sensor_width_mm"] = shot.lens.sensor_width_mm
        values["focal_length_mm"] = camera.focal_length_mm * scale
        if "focal_length_mm" in tracks:
            tracks["focal_length_mm"] = tuple(mm * scale for mm in tracks["focal_length_mm"])
    shot = replace(shot, framing=framing, lens=replace(shot.lens, **values))
    for parameter in set(LensParameter).intersection(values):
        curve, track = shot.curves.of(parameter), tracks.get(parameter)
        keys = linear_keys(camera.lens_frames, track, curve.scale) if track else ()
        shot = shot.with_curve(parameter, replace(curve, keys=keys))
    return shot


def lens_values(camera: SceneCamera) -> dict[str, Any]:
    """Return the fields of Lens that the file has for a camera, at its first frame."""
    told = {field: getattr(camera, field) for field in (*ANGLE, *OPENING)}
    return {field: value for field, value in told.items() if value is not None}
