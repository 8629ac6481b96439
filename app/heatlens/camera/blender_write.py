"""A camera as a Python script for Blender.

The active camera takes the lens, so that a shot without a placement keeps its own; where no camera
is active there is a new one. Blender has no infinity: that focus is INFINITE_M away.
"""

import pprint
from typing import Any

from heatlens.camera.placement import camera_to_world, euler_deg
from heatlens.camera.samples import CameraSamples, finite_m

_PROPERTIES = {
    "focal_length_mm": "lens",
    "sensor_width_mm": "sensor_width",
    "sensor_height_mm": "sensor_height",
    "f_stop": "dof.aperture_fstop",
    "squeeze": "dof.aperture_ratio",  # Cycles divides the width of the lens by it
}
_ROTATION_ORDER = "XYZ"  # Blender's own
_SCRIPT = '''\
"""A lens of heatlens for Blender: run it in the text editor, or blender SCENE --python THIS_FILE.

The active camera takes it; where no camera is active there is a new one.
"""

import math

import bpy

NAME = {name}
FRAMES = {frames}
# One value, or a list of one for each frame. Lengths are in millimetres, distances in metres,
# angles in degrees about x, y and z; z is up.
LENS = {lens}
FOCUS_DISTANCE_M = {focus}
LOCATION_M = {location}
ROTATION_DEG = {rotation}


def camera_object():
    """The active camera with a lens of its own and no keys on it, or a new camera."""
    active = bpy.context.object
    if active is not None and active.type == "CAMERA":
        active.data = active.data.copy()
        active.data.animation_data_clear()
        return active
    made = bpy.data.objects.new(NAME, bpy.data.cameras.new(NAME))
    bpy.context.collection.objects.link(made)
    return made


def set_track(owner, path, values):
    """Set a property, with a key at each frame where it moves."""
    *parents, name = path.split(".")
    holder = owner
    for parent in parents:
        holder = getattr(holder, parent)
    if not isinstance(values, list):
        setattr(holder, name, values)
        return
    for frame, value in zip(FRAMES, values):
        setattr(holder, name, value)
        owner.keyframe_insert(data_path=path, frame=frame)


def scaled(values, factor):
    """A number, a vector, or a list of either, times a factor."""
    if isinstance(values, (list, tuple)):
        return type(values)(scaled(value, factor) for value in values)
    return values * factor


scene = bpy.context.scene
units_per_m = 1 / scene.unit_settings.scale_length
camera = camera_object()
camera.data.sensor_fit = "HORIZONTAL"
for path, values in LENS.items():
    set_track(camera.data, path, values)
if FOCUS_DISTANCE_M is not None:
    camera.data.dof.use_dof = True
    camera.data.dof.focus_object = None
    set_track(camera.data, "dof.focus_distance", scaled(FOCUS_DISTANCE_M, units_per_m))
if LOCATION_M is not None:
    camera.animation_data_clear()
    camera.rotation_mode = "XYZ"
    set_track(camera, "location", scaled(LOCATION_M, units_per_m))
    set_track(camera, "rotation_euler", scaled(ROTATION_DEG, math.pi / 180))
if scene.camera is None:
    scene.camera = camera
'''


def blender_text(camera: CameraSamples) -> str:
    """Return the Python script, which needs nothing but Blender."""
    tracks = camera.lens_tracks
    lens = {path: _values(tracks[name]) for name, path in _PROPERTIES.items() if name in tracks}
    focus = camera.focus_distance_m
    location, rotation = _placement(camera)
    return _SCRIPT.format(
        name=ascii(camera.name),
        frames=_literal(list(camera.frames)),
        lens=_literal(lens),
        focus=_literal(None if focus is None else _values([finite_m(value) for value in focus])),
        location=_literal(location),
        rotation=_literal(rotation),
    )


def _placement(camera: CameraSamples) -> tuple[Any, Any]:
    """Return location and rotation in Blender's world, where z is up; both may be None.

    A value is a list of one vector for each frame where it moves, else one vector. Blender's
    cameras look along -z, as ours do.
    """
    if camera.world_to_camera is None:
        return None, None
    placed = camera_to_world(camera.world_to_camera, camera.up_axis, "z")
    rotation = euler_deg(placed[:, :3, :3], _ROTATION_ORDER)
    return tuple(
        _values([tuple(row) for row in rows.tolist()]) for rows in (placed[:, :3, 3], rotation)
    )


def _values(values: Any) -> Any:
    """Return a list where the value changes, else the one value."""
    return values[0] if all(value == values[0] for value in values) else list(values)


def _literal(value: Any) -> str:
    return pprint.pformat(value, width=100, compact=True, sort_dicts=False)
