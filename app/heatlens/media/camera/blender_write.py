"""Write a camera as a Python script for Blender.

The script sets the lens of the scene's camera, or of the camera that is named in the script; if
there is none, it makes one. It sets the frame rate and the range of frames, and interpolates
linearly between frames. Blender has no infinity: a focus at infinity becomes INFINITE_M.
"""

import math
import pprint
from dataclasses import fields
from typing import Any

from heatlens.core.base.paths import data_dir
from heatlens.core.model.lens.opening_fields import OpeningFields
from heatlens.media.camera.placement import camera_to_world, euler_deg
from heatlens.media.camera.samples import OPENING_TRACKS, CameraSamples, finite_m

_DIAPHRAGM = ("blades", "blade_rotation_deg")
_PROPERTIES = {
    "focal_length_mm": "lens",
    "sensor_width_mm": "sensor_width",
    "sensor_height_mm": "sensor_height",
    "f_stop": "dof.aperture_fstop",
    "nominal_f_stop": '["nominal_f_stop"]',  # our own property, beside Blender's
    "squeeze": "dof.aperture_ratio",  # Cycles divides the width of the lens by it
    # Blender has no such properties; they are kept as custom properties.
    **{name: f'["{name}"]' for name in OPENING_TRACKS if name not in _DIAPHRAGM},
}
_BLADES, _ROTATION = "dof.aperture_blades", "dof.aperture_rotation"
_IMAGE = '["aperture_image"]'
_ROTATION_ORDER = "XYZ"  # Blender's own


def blender_text(camera: CameraSamples) -> str:
    """Return the Python script: the text of `set_lens.py` with the values of `camera` filled in.

    The script needs only Blender.
    """
    focus = camera.focus_distance_m
    location, rotation = _location_and_rotation(camera)
    fps, fps_base = _blender_rate(camera.frames_per_second)
    values = {
        "NAME": ascii(camera.name),
        "FPS": fps,
        "FPS_BASE": fps_base,
        "FRAMES": _literal(list(camera.frames)),
        "LENS": _literal(_lens_properties(camera)),
        "FOCUS_DISTANCE_M": _literal(
            None if focus is None else _constant_or_list([*map(finite_m, focus)])
        ),
        "LOCATION_M": _literal(location),
        "ROTATION_DEG": _literal(rotation),
    }
    text = (data_dir("assets") / "blender" / "set_lens.py").read_text(encoding="utf-8")
    for name, value in values.items():
        text = text.replace(f"\n{name} = None", f"\n{name} = {value}", 1)
    return text


def _lens_properties(camera: CameraSamples) -> dict[str, object]:
    """Return the value of each property; None removes a custom property of an earlier lens.

    A camera with an f-stop defines its opening too: missing values are those of a plain lens,
    whatever the camera in Blender had before.
    """
    tracks, image = camera.lens_tracks, camera.aperture_image
    # A plain lens leaves no properties of our own on a camera of Blender.
    plain_values = {field.name: field.default for field in fields(OpeningFields)}
    animated: dict[str, object] = {}
    for name in (name for name in _PROPERTIES if name in tracks):
        value, path = _constant_or_list(tracks[name]), _PROPERTIES[name]
        is_plain = path.startswith("[") and value == plain_values.get(name)
        animated[path] = None if is_plain else value
    if camera.f_stop is None and "blades" not in camera.opening:
        return animated
    removed_properties = {path: None for path in _PROPERTIES.values() if path.startswith("[")}
    return (
        removed_properties
        | animated
        | _diaphragm(camera)
        | {_IMAGE: None if image is None else image.path}
    )


def _diaphragm(camera: CameraSamples) -> dict[str, object]:
    """Return Blender's blades and their rotation in radians.

    In both programs the corners lie on the circle. At rotation 0 Blender has the middle of a blade
    at the right, heatlens a corner at the top; both turn anticlockwise.
    """
    zeros = (0.0,) * len(camera.frames)
    blades, rotation = (camera.opening.get(name, zeros) for name in _DIAPHRAGM)
    blade_counts = [round(value) for value in blades]
    rotations = [
        math.remainder(math.pi / 2 + math.radians(deg) - math.pi / n, 2 * math.pi / n) if n else 0.0
        for n, deg in zip(blade_counts, rotation, strict=True)
    ]
    return {_BLADES: _constant_or_list(blade_counts), _ROTATION: _constant_or_list(rotations)}


def _blender_rate(frames_per_second: float) -> tuple[int, float]:
    """Return Blender's integer rate and its divisor: 24 and 1.001 for 23.976."""
    integer_rate = round(frames_per_second) or 1
    divisor = integer_rate / frames_per_second
    return integer_rate, 1.001 if abs(divisor - 1.001) < 1e-5 else divisor


def _location_and_rotation(camera: CameraSamples) -> tuple[object, object]:
    """Return location and rotation in Blender's world, where z is up; both may be None.

    A moving value is a list of one vector for each frame, else it is one vector. Blender's cameras
    look along -z, as ours do.
    """
    if camera.world_to_camera is None:
        return None, None
    camera_matrices = camera_to_world(camera.world_to_camera, camera.up_axis, "z")
    rotation = euler_deg(camera_matrices[:, :3, :3], _ROTATION_ORDER)
    return tuple(
        _constant_or_list([tuple(row) for row in rows.tolist()])
        for rows in (camera_matrices[:, :3, 3], rotation)
    )


def _constant_or_list(values: Any) -> Any:
    """Return the first value if all are equal, else a list with the value at each frame."""
    return values[0] if all(value == values[0] for value in values) else list(values)


def _literal(value: Any) -> str:
    """Return the value as Python source text."""
    return pprint.pformat(value, width=100, compact=True, sort_dicts=False)
