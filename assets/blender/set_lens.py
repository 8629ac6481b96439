"""A lens of heatlens for Blender: run it in the text editor, or blender SCENE --python THIS_FILE.

It goes to the scene's camera, or to the one named in CAMERA; if there is none, one is added.
"""

import math

import bpy

CAMERA = ""  # name of the camera object that takes the lens; "" for the camera of the scene
NAME = None
FPS = None
FPS_BASE = None  # Blender's rate is FPS / FPS_BASE
FRAMES = None
# One value, or a list of one for each frame. Lengths are in millimetres, distances in metres,
# angles in degrees about x, y and z; z is up.
LENS = None
FOCUS_DISTANCE_M = None
LOCATION_M = None
ROTATION_DEG = None


def camera_object():
    """Return the camera that takes the lens: nothing else has that lens, and no keys are on it."""
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
    for frame, value in zip(FRAMES, values):  # noqa: B905 (an older Python has no strict)
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
    """Return the curves of a data-block: since Blender 4.4 an action can hold those of several."""
    animation = owner.animation_data
    slot = getattr(animation, "action_slot", None)
    if slot is None:
        return list(animation.action.fcurves)
    strips = [strip for layer in animation.action.layers for strip in layer.strips]
    bags = [bag for strip in strips for bag in strip.channelbags if bag.slot == slot]
    return [curve for bag in bags for curve in bag.fcurves]


def scaled(values, factor):
    """Return a number, a vector, or a list of either, times a factor."""
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
