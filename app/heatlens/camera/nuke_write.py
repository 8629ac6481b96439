"""A camera as the text of Nuke nodes, to be pasted or read as a script.

Camera2 is read by every Nuke from 6 on. Nuke has no infinity: that focus is INFINITE_M away. The
nodes that defocus follow, see `nuke_defocus`.
"""

from collections.abc import Iterator

from heatlens.camera.nuke_defocus import curve_or_number, defocus_text, knob_value, quoted
from heatlens.camera.placement import camera_to_world, euler_deg
from heatlens.camera.samples import LENS_TRACKS, OPENING_TRACKS, CameraSamples, finite_m

_KNOBS = {
    "focal_length_mm": "focal",
    "sensor_width_mm": "haperture",
    "sensor_height_mm": "vaperture",
    "f_stop": "fstop",
}
_NOMINAL = "nominal_f_stop"  # as those of the opening, a knob of our own on a tab called heatlens
_ROTATION_ORDER = "ZXY"  # Nuke's own


def nuke_text(camera: CameraSamples, meters_per_unit: float = 1.0) -> str:
    """Return the text of the nodes for a scene whose unit is `meters_per_unit` metres."""
    knobs = [*_placement(camera, meters_per_unit), *_lens(camera, meters_per_unit)]
    lines = ["inputs 0", *knobs, f"name {camera.identifier}"]
    node = "Camera2 {\n" + "".join(f" {line}\n" for line in lines) + "}\n"
    return node + defocus_text(camera, meters_per_unit)


def _lens(camera: CameraSamples, meters_per_unit: float) -> Iterator[str]:
    tracks = camera.lens_tracks
    for name, knob in _KNOBS.items():
        if name in tracks:
            yield f"{knob} {knob_value(camera, tracks[name])}"
    if "focus_distance_m" in tracks:
        distances = [finite_m(value) / meters_per_unit for value in tracks["focus_distance_m"]]
        yield f"focal_point {knob_value(camera, distances)}"
    own = [name for name in (_NOMINAL, *OPENING_TRACKS) if name in tracks]
    image = camera.aperture_image
    if own or image is not None:
        yield "addUserKnob {20 heatlens}"
    for name in own:
        yield f'addUserKnob {{7 {name} l "{LENS_TRACKS[name]}"}}'
        yield f"{name} {knob_value(camera, tracks[name])}"
    if image is not None:
        yield 'addUserKnob {2 aperture_image l "aperture image"}'
        yield f"aperture_image {quoted(image.path)}"


def _placement(camera: CameraSamples, meters_per_unit: float) -> Iterator[str]:
    """Yield the knobs of the placement; in Nuke y is up and cameras look along -z."""
    if camera.world_to_camera is None:
        return
    placed = camera_to_world(camera.world_to_camera, camera.up_axis, "y")
    translate = placed[:, :3, 3] / meters_per_unit
    rotate = euler_deg(placed[:, :3, :3], _ROTATION_ORDER)
    yield f"rot_order {_ROTATION_ORDER}"
    for knob, values in (("translate", translate), ("rotate", rotate)):
        yield f"{knob} {{{' '.join(curve_or_number(camera, axis.tolist()) for axis in values.T)}}}"
