"""Write a camera as a Python script for Blender.

The script sets the lens of the scene's camera, or of the camera that is named in the script; if
there is none, it makes one. It sets the frame rate and the range of frames, and interpolates
linearly between frames. Blender has no infinity: a focus at infinity becomes INFINITE_M.
"""

import math
import pprint
from typing import Any

from heatlens.camera.placement import camera_to_world, euler_deg
from heatlens.camera.samples import OPENING_TRACKS, CameraSamples, finite_m

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
_SCRIPT = '''\
"""A lens of heatlens for Blender: run it in the text editor, or blender SCENE --python THIS_FILE.

It goes to the scene's camera, or to the one named in CAMERA; if there is none, one is added.
"""

import math

import bpy

CAMERA = ""  # name of the camera object that takes the lens; "" for the camera of the scene
NAME = {name}
FPS, FPS_BASE = {fps}, {fps_base}  # Blender's rate is their quotient
FRAMES = {frames}
# One value, or a list of one for each frame. Lengths are in millimetres, distances in metres,
# angles in degrees about x, y and z; z is up.
LENS = {lens}
FOCUS_DISTANCE_M = {focus}
LOCATION_M = {location}
ROTATION_DEG = {rotation}


def camera_object():
    """The camera that takes the lens: nothing else has that lens, and no keys are on it."""
    scene = bpy.context.scene
    found = bpy.data.objects.get(CAMERA) if CAMERA else scene.camera
    if CAMERA and (found is None or found.type != "CAMERA"):
        raise SystemExit("There is no camera called " + repr(CAMERA) + " in this file.")
    if found is None or found.type != "CAMERA":
        found = bpy.data.objects.new(NAME, bpy.data.cameras.new(NAME))
        scene.collection.objects.link(found)
    else:
        if found.data.users > 1:
            found.data = found.data.copy()
        found.data.animation_data_clear()
    scene.camera = found
    return found


def set_track(owner, path, values):
    """Set a property, with a key at each frame where it moves and straight lines between them."""
    if not isinstance(values, list):
        set_value(owner, path, values)
        return
    for frame, value in zip(FRAMES, values):
        set_value(owner, path, value)
        owner.keyframe_insert(data_path=path, frame=frame)
    for curve in curves_of(owner):
        if curve.data_path == path:
            for point in curve.keyframe_points:
                point.interpolation = "LINEAR"


def set_value(owner, path, value):
    """Set a property of Blender, or one of our own, whose path is in brackets; None removes it."""
    if path.startswith("[") and value is None:
        owner.pop(path.strip('[]"'), None)
        return
    if path.startswith("["):
        owner[path.strip('[]"')] = value
        return
    *parents, name = path.split(".")
    for parent in parents:
        owner = getattr(owner, parent)
    setattr(owner, name, value)


def curves_of(owner):
    """The curves of a data-block: since Blender 4.4 an action can hold those of several."""
    animation = owner.animation_data
    slot = getattr(animation, "action_slot", None)
    if slot is None:
        return list(animation.action.fcurves)
    strips = [strip for layer in animation.action.layers for strip in layer.strips]
    bags = [bag for strip in strips for bag in strip.channelbags if bag.slot == slot]
    return [curve for bag in bags for curve in bag.fcurves]


def scaled(values, factor):
    """A number, a vector, or a list of either, times a factor."""
    if isinstance(values, (list, tuple)):
        return type(values)(scaled(value, factor) for value in values)
    return values * factor


def place(camera):
    """Stand where the plate was seen from, whatever has moved the camera before."""
    camera.animation_data_clear()
    camera.parent = None
    for constraint in camera.constraints:
        constraint.mute = True
    camera.rotation_mode = "XYZ"
    set_track(camera, "location", scaled(LOCATION_M, units_per_m))
    set_track(camera, "rotation_euler", scaled(ROTATION_DEG, math.pi / 180))


scene = bpy.context.scene
units_per_m = 1 / scene.unit_settings.scale_length
scene.render.fps, scene.render.fps_base = FPS, FPS_BASE
if len(FRAMES) > 1:
    scene.frame_start, scene.frame_end = FRAMES[0], FRAMES[-1]
camera = camera_object()
camera.data.sensor_fit = "HORIZONTAL"
for path, values in LENS.items():
    # Blender takes a unit of its scene for a metre of its lens, whatever the scale of units says.
    if path == "dof.aperture_fstop":
        values = scaled(values, 1 / units_per_m)
    set_track(camera.data, path, values)
if FOCUS_DISTANCE_M is not None:
    camera.data.dof.use_dof = True
    camera.data.dof.focus_object = None
    set_track(camera.data, "dof.focus_distance", scaled(FOCUS_DISTANCE_M, units_per_m))
if LOCATION_M is not None:
    place(camera)
'''


def blender_text(camera: CameraSamples) -> str:
    """Return the Python script, which needs only Blender."""
    focus = camera.focus_distance_m
    location, rotation = _placement(camera)
    fps, fps_base = _rate(camera.frames_per_second)
    return _SCRIPT.format(
        name=ascii(camera.name),
        fps=fps,
        fps_base=fps_base,
        frames=_literal(list(camera.frames)),
        lens=_literal(_lens(camera)),
        focus=_literal(None if focus is None else _values([finite_m(value) for value in focus])),
        location=_literal(location),
        rotation=_literal(rotation),
    )


def _lens(camera: CameraSamples) -> dict[str, object]:
    """Return the value of each property; None removes one of our own that an earlier lens left.

    A camera with an f-stop defines its opening too: missing values are those of a plain lens,
    whatever the camera in Blender had before.
    """
    tracks, image = camera.lens_tracks, camera.aperture_image
    told = {path: _values(tracks[name]) for name, path in _PROPERTIES.items() if name in tracks}
    if camera.f_stop is None and "blades" not in camera.opening:
        return told
    own = {path: None for path in _PROPERTIES.values() if path.startswith("[")}
    return own | told | _diaphragm(camera) | {_IMAGE: None if image is None else image.path}


def _diaphragm(camera: CameraSamples) -> dict[str, object]:
    """Return Blender's blades and their rotation in radians.

    In both programs the corners lie on the circle. At rotation 0 Blender has the middle of a blade
    at the right, heatlens a corner at the top; both turn anticlockwise.
    """
    still = (0.0,) * len(camera.frames)
    blades, rotation = (camera.opening.get(name, still) for name in _DIAPHRAGM)
    number = [round(value) for value in blades]
    turns = [
        math.remainder(math.pi / 2 + math.radians(deg) - math.pi / n, 2 * math.pi / n) if n else 0.0
        for n, deg in zip(number, rotation, strict=True)
    ]
    return {_BLADES: _values(number), _ROTATION: _values(turns)}


def _rate(frames_per_second: float) -> tuple[int, float]:
    """Return Blender's integer rate and its divisor: 24 and 1.001 for 23.976."""
    whole = round(frames_per_second) or 1
    base = whole / frames_per_second
    return whole, 1.001 if abs(base - 1.001) < 1e-5 else base


def _placement(camera: CameraSamples) -> tuple[object, object]:
    """Return location and rotation in Blender's world, where z is up; both may be None.

    A moving value is a list of one vector for each frame, else it is one vector. Blender's cameras
    look along -z, as ours do.
    """
    if camera.world_to_camera is None:
        return None, None
    placed = camera_to_world(camera.world_to_camera, camera.up_axis, "z")
    rotation = euler_deg(placed[:, :3, :3], _ROTATION_ORDER)
    return tuple(
        _values([tuple(row) for row in rows.tolist()]) for rows in (placed[:, :3, 3], rotation)
    )


def _values(values: Any) -> Any:
    """Return a list if the value changes, else a single value."""
    return values[0] if all(value == values[0] for value in values) else list(values)


def _literal(value: Any) -> str:
    return pprint.pformat(value, width=100, compact=True, sort_dicts=False)
