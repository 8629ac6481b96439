"""Write a camera as the text of Nuke nodes, to be pasted or read as a script.

Camera2 is read by every Nuke from 6 on. Nuke has no infinity: that focus is INFINITE_M away. The
nodes that defocus follow it, with as much of the lens opening as they support.

Bokeh takes the whole lens and computes the amount of blur from it. ZDefocus takes the focus
distance S, the shape, and a `size`: with depths as distances it blurs a point at distance z by
size (1 - S / z), so the size is the blur at infinity. The radius of that disc on the sensor is
f^2 / (2 N S), with f the focal length and N the f-stop of a renderer. A knob of our own holds it as
a share of the sensor's width, and an expression multiplies it by the width of the picture.

The names of the knobs are those of Foundry's reference guide and of Nuke 17.0v3. Foundry does not
say whether a size is half a diameter, as in Epic's example for Unreal, where the rotation of the
blades begins, and how the curvature of blades is measured. The note in the file asks the user to
compare.
"""

from collections.abc import Iterator, Mapping, Sequence

from heatlens.media.camera.placement import camera_to_world, euler_deg
from heatlens.media.camera.samples import (
    INFINITE_M,
    LENS_TRACKS,
    OPENING_TRACKS,
    CameraSamples,
    finite_m,
    with_renderer_f_stop,
)

_KNOBS = {
    "focal_length_mm": "focal",
    "sensor_width_mm": "haperture",
    "sensor_height_mm": "vaperture",
    "f_stop": "fstop",
}
_NOMINAL = "nominal_f_stop"  # a knob of our own on the tab heatlens, like those of the opening
_ROTATION_ORDER = "ZXY"  # Nuke's own
_BOKEH_SHAPE = {"blades": "kNumSides", "blade_rotation_deg": "kRotation"}
_ZDEFOCUS_SHAPE = {"blades": "blades", "blade_rotation_deg": "rotation"}
_BOKEH_LENS = {
    "focal_length_mm": "focalLength",
    "sensor_width_mm": "apertureWidth",
    "sensor_height_mm": "apertureHeight",
}
_SUPPORTED_FIELDS = ("blades", "blade_rotation_deg", "blade_curvature", "widest_f_stop")
_COMPARE_NOTE = (
    "Foundry does not document the zero of rotation or the scale of curvature: compare by eye"
)
_HALF_DISC = "half_disc"
_SIZE_NOTE = (
    "Its size is half the disc of a point at infinity, half_disc times the width of the "
    "picture, for depths that hold distances in the unit of this file"
)
_INVERSE_NOTE = "Put the node {} before it, which turns the 1/z of the plate's depth.Z into that"
_MAX_SIZE = "width/4"  # Nuke's default would cut objects near the camera


def nuke_text(
    camera: CameraSamples, meters_per_unit: float = 1.0, holds_inverse: bool = False
) -> str:
    """Return the text of the nodes for a scene whose unit is `meters_per_unit` meters.

    With `holds_inverse` the depth of the plate is 1/z, and a node turns it into distances.
    """
    knobs = [*_placement_knobs(camera, meters_per_unit), *_lens_knobs(camera, meters_per_unit)]
    lines = ["inputs 0", *knobs, f"name {camera.identifier}"]
    node = "Camera2 {\n" + "".join(f" {line}\n" for line in lines) + "}\n"
    return node + defocus_text(camera, meters_per_unit, holds_inverse)


def _lens_knobs(camera: CameraSamples, meters_per_unit: float) -> Iterator[str]:
    """Yield the knobs of the lens; values that Nuke lacks are on the tab heatlens."""
    tracks = camera.lens_tracks
    for name, knob in _KNOBS.items():
        if name in tracks:
            yield f"{knob} {knob_value(camera, tracks[name])}"
    if "focus_distance_m" in tracks:
        distances = [finite_m(value) / meters_per_unit for value in tracks["focus_distance_m"]]
        yield f"focal_point {knob_value(camera, distances)}"
    custom_names = [name for name in (_NOMINAL, *OPENING_TRACKS) if name in tracks]
    image = camera.aperture_image
    if custom_names or image is not None:
        yield "addUserKnob {20 heatlens}"
    for name in custom_names:
        yield f'addUserKnob {{7 {name} l "{LENS_TRACKS[name]}"}}'
        yield f"{name} {knob_value(camera, tracks[name])}"
    if image is not None:
        yield 'addUserKnob {2 aperture_image l "aperture image"}'
        yield f"aperture_image {quote_tcl(image.path)}"


def _placement_knobs(camera: CameraSamples, meters_per_unit: float) -> Iterator[str]:
    """Yield the knobs of the placement; in Nuke y is up and cameras look along -z."""
    if camera.world_to_camera is None:
        return
    camera_matrices = camera_to_world(camera.world_to_camera, camera.up_axis, "y")
    translate = camera_matrices[:, :3, 3] / meters_per_unit
    rotate = euler_deg(camera_matrices[:, :3, :3], _ROTATION_ORDER)
    yield f"rot_order {_ROTATION_ORDER}"
    for knob, values in (("translate", translate), ("rotate", rotate)):
        yield f"{knob} {{{' '.join(curve_or_number(camera, axis.tolist()) for axis in values.T)}}}"


def has_shape(camera: CameraSamples) -> bool:
    """Return whether the opening has a shape: it is oval, has blades or the like, or an image."""
    tracks = camera.lens_tracks
    is_oval = set(tracks.get("squeeze", (1.0,))) != {1.0}
    return is_oval or bool(camera.shaped_fields) or camera.aperture_image is not None


def defocus_text(camera: CameraSamples, meters_per_unit: float, holds_inverse: bool = False) -> str:
    """Return the text of ZDefocus with its keyed focus, and of Bokeh where the opening has a shape.

    Both are left out for a round opening without a focus. Bokeh comes last, because a Nuke before
    14 lacks that node and stops reading there.
    """
    if not has_shape(camera) and "focus_distance_m" not in camera.lens_tracks:
        return ""
    zdefocus = _defocus_node(
        "ZDefocus2", camera, _zdefocus_knobs(camera, meters_per_unit), holds_inverse
    )
    if holds_inverse:
        zdefocus = _distance_node(camera) + zdefocus
    if not has_shape(camera):
        return zdefocus
    return zdefocus + _defocus_node("Bokeh", camera, _bokeh_knobs(camera, meters_per_unit))


def unsupported_note(camera: CameraSamples) -> str:
    """Return a sentence on the values of the opening that the nodes cannot hold, or ""."""
    names = [OPENING_TRACKS[name] for name in camera.shaped_fields if name not in _SUPPORTED_FIELDS]
    names += [] if camera.aperture_image is None else ["aperture image"]
    if not names:
        return ""
    words = " and ".join((", ".join(names[:-1]), names[-1])) if names[1:] else names[0]
    return (
        f"Nuke's ZDefocus and Bokeh cannot represent {words}; the camera keeps it on its tab "
        "called heatlens."
    )


def _distance_node(camera: CameraSamples) -> str:
    """Return the node that turns the 1/z of Nuke's own renders into distances; 0 is infinity."""
    knobs = (
        "inputs 0",
        "channel0 depth",
        f"expr0 {quote_tcl(f'depth.Z > 0 ? 1 / depth.Z : {INFINITE_M:g}')}",
        f"name {camera.identifier}_distance",
    )
    return "Expression {\n" + "".join(f" {knob}\n" for knob in knobs) + "}\n"


def _defocus_node(
    kind: str, camera: CameraSamples, knobs: Iterator[str], holds_inverse: bool = False
) -> str:
    """Return the text of a defocus node of this kind, with notes for the user as its label."""
    compare_note = _COMPARE_NOTE if has_shape(camera) else ""  # a disc has no blades to compare
    size_note = _SIZE_NOTE if kind == "ZDefocus2" and _half_discs(camera) else ""
    inverse_note = _INVERSE_NOTE.format(f"{camera.identifier}_distance") if holds_inverse else ""
    sentences = size_note, inverse_note, unsupported_note(camera).rstrip("."), compare_note
    note = ". ".join(sentence for sentence in sentences if sentence)
    label = (f"label {quote_tcl(note + '.')}",) if note else ()
    lines = ("inputs 0", *knobs, *label, f"name {camera.identifier}_{kind}")
    return f"{kind} {{\n" + "".join(f" {line}\n" for line in lines) + "}\n"


def _bokeh_knobs(camera: CameraSamples, meters_per_unit: float) -> Iterator[str]:
    """Yield the knobs of the node Bokeh."""
    tracks = camera.lens_tracks
    yield "depthStyle Real"
    if "focus_distance_m" in tracks:
        yield f"focalPlane {_focus_value(camera, meters_per_unit)}"
    yield "realWorldLens true"
    yield from _unchanged_knobs(camera, _BOKEH_LENS)
    f_stops = tracks.get(
        "nominal_f_stop", tracks.get("f_stop")
    )  # the Bokeh node expects the f-stop of a real lens
    if f_stops is not None:
        yield f"fStop {knob_value(camera, f_stops)}"
    yield "worldScale m"
    yield f"worldScaleMultiplier {meters_per_unit!r}"
    yield "filmFormat Custom"
    yield f"kernelType {quote_tcl('Aperture Blades' if _has_blades(tracks) else 'Circular')}"
    yield from _unchanged_knobs(camera, _BOKEH_SHAPE)
    yield f"kCurvature {_curvature_value(camera)}"
    yield f"kAspectRatio {_aspect_value(camera)}"
    yield "kSoftness 0.0"


def _zdefocus_knobs(camera: CameraSamples, meters_per_unit: float) -> Iterator[str]:
    """Yield the knobs of the node ZDefocus."""
    yield "math depth"
    if "focus_distance_m" in camera.lens_tracks:
        yield f"center {_focus_value(camera, meters_per_unit)}"
    yield f"filter_type {'bladed' if _has_blades(camera.lens_tracks) else 'disc'}"
    yield from _unchanged_knobs(camera, _ZDEFOCUS_SHAPE)
    yield f"roundness {_curvature_value(camera)}"
    yield f"aspect {_aspect_value(camera)}"
    yield "inner_brightness 1.0"  # an even disc; Nuke's default has a darker middle
    if half_discs := _half_discs(camera):
        yield f"size {{{{width*{_HALF_DISC}}}}}"
        yield f"max_size {{{{{_MAX_SIZE}}}}}"
        yield "addUserKnob {20 heatlens}"
        yield f'addUserKnob {{7 {_HALF_DISC} l "half disc at infinity, in widths"}}'
        yield f"{_HALF_DISC} {knob_value(camera, half_discs)}"


def _half_discs(camera: CameraSamples) -> list[float]:
    """Return the disc radius at infinity, as a share of the picture's width, at each frame.

    Empty if the camera lacks the values for it.
    """
    tracks = with_renderer_f_stop(camera).lens_tracks
    names = ("focal_length_mm", "f_stop", "focus_distance_m", "sensor_width_mm")
    if any(name not in tracks for name in names):
        return []
    frames = zip(*(tracks[name] for name in names), strict=True)
    return [f_mm**2 / (2 * n * finite_m(s_m) * 1e3 * w_mm) for f_mm, n, s_m, w_mm in frames]


def _has_blades(tracks: Mapping[str, tuple[float, ...]]) -> bool:
    return max(tracks.get("blades", (0.0,))) > 0


def _unchanged_knobs(camera: CameraSamples, names: Mapping[str, str]) -> Iterator[str]:
    """Yield the knobs that take a track unchanged; without blades Nuke's default stays."""
    tracks = camera.lens_tracks
    for name, knob in names.items():
        if name in tracks and (name != "blades" or _has_blades(tracks)):
            yield f"{knob} {knob_value(camera, tracks[name])}"


def _focus_value(camera: CameraSamples, meters_per_unit: float) -> str:
    """Return the focus distance as the value of a knob, in units of the scene."""
    focus_m = camera.lens_tracks["focus_distance_m"]
    return knob_value(camera, [finite_m(value) / meters_per_unit for value in focus_m])


def _curvature_value(camera: CameraSamples) -> str:
    """Return the curvature of the blades as the value of a knob; 0 if it is unknown."""
    zeros = (0.0,) * len(camera.frames)  # Nuke's default blades are a little round
    return knob_value(camera, camera.lens_tracks.get("blade_curvature", zeros))


def _aspect_value(camera: CameraSamples) -> str:
    """Return the width of the opening over its height, as the value of a knob."""
    squeeze = camera.lens_tracks.get("squeeze", (1.0,) * len(camera.frames))
    return knob_value(camera, [1.0 / value for value in squeeze])


def knob_value(camera: CameraSamples, values: Sequence[float]) -> str:
    """Return the value of a knob as text: a number, or a list of the curve that animates it."""
    element = curve_or_number(camera, values)
    return f"{{{element}}}" if element.startswith("{") else element


def curve_or_number(camera: CameraSamples, values: Sequence[float]) -> str:
    """Return one value of a knob: a number if it is constant, else a curve with all keys."""
    if min(values) == max(values):
        return repr(values[0])
    keys = (f"x{frame} {value!r}" for frame, value in zip(camera.frames, values, strict=True))
    return f"{{curve {' '.join(keys)}}}"


def quote_tcl(text: str) -> str:
    """Return a text as one word of Tcl, which counts quotes, brackets, $ and backslashes."""
    for sign in '\\"[]{}$':
        text = text.replace(sign, f"\\{sign}")
    return f'"{text}"'
