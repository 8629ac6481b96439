"""Set the up axis and the unit of a scene whose file does not define them.

PLY, STL and OBJ have no unit and no up axis. A shot holds them for its scene (`Framing.up_axis`,
`Framing.meters_per_unit`); a first shot guesses them and adds a note.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import open_regular_file
from heatlens.core.model.shot.framing import Framing, WorldAxis
from heatlens.media.scene.scene import Array, Motion, Scene
from heatlens.media.scene.scene_bounds import bounds_m

SUFFIXES_WITHOUT_UNIT = (".obj", ".ply", ".stl")
_HEAD_BYTES = 400  # enough for the first lines of these formats
# By format: sizes, and the unit in meters that is guessed for a scene larger than this number.
_UNITS = {".stl": ((5.0, 1e-3),), ".obj": ((5000.0, 1e-3), (100.0, 1e-2)), ".ply": ((100.0, 1e-3),)}
_NAMES = {1.0: "metres", 1e-2: "centimetres", 1e-3: "millimetres"}
# The columns are the images of x, y and z of a file, a rotation that turns its up axis upwards.
_ROTATIONS = {
    WorldAxis.X: ((0, -1, 0), (1, 0, 0), (0, 0, 1)),
    WorldAxis.Y: ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    WorldAxis.Z: ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
}


@dataclass(frozen=True)
class Placing:
    """The up axis and the unit chosen for a file that has none; None means to guess."""

    up_axis: WorldAxis | None = None
    meters_per_unit: float | None = None


def lacks_placing(scene: Scene) -> bool:
    """Return True for a scene whose file defines neither a unit nor an up axis."""
    return scene.path.suffix.lower() in SUFFIXES_WITHOUT_UNIT


def place_for_first_shot(
    scene: Scene, framing: Framing, chosen_placing: Placing
) -> tuple[Scene, Framing]:
    """Return the scene and the framing with the chosen values, and guesses with notes for the rest.

    Raises InputError if values are given for a file that defines them itself.
    """
    if not lacks_placing(scene):
        if chosen_placing != Placing():
            raise InputError(
                f"{scene.path} defines its own unit and up axis: leave --up-axis and "
                "--meters-per-unit out."
            )
        return scene, framing
    axis = chosen_placing.up_axis or _likely_axis(scene.path)
    unit_m = chosen_placing.meters_per_unit
    size = float(np.ptp(bounds_m(scene, 1), axis=0).max())
    unit_m = unit_m or _likely_unit_m(scene.path, size)
    framing = replace(framing, up_axis=axis, meters_per_unit=unit_m)
    notes = (*scene.notes, *_guess_notes(scene.path, framing, chosen_placing, size))
    return replace(place_scene(scene, framing), notes=notes), framing


def place_scene(scene: Scene, framing: Framing | None) -> Scene:
    """Return the scene rotated to the framing's up axis, and scaled to meters by its unit."""
    target = framing or Framing()
    current_placing = (scene.up_axis, scene.meters_per_unit)
    if not lacks_placing(scene) or current_placing == (target.up_axis, target.meters_per_unit):
        return scene
    change = _placing_matrix(target.up_axis, target.meters_per_unit) @ np.linalg.inv(
        _placing_matrix(*current_placing)
    )
    return replace(
        scene,
        instances=tuple(
            replace(instance, to_world=change @ instance.to_world) for instance in scene.instances
        ),
        motion=None if scene.motion is None else _transform_motion(scene.motion, change),
        up_axis=target.up_axis,
        meters_per_unit=target.meters_per_unit,
    )


def _placing_matrix(axis: WorldAxis, unit_m: float) -> Array:
    """Return the matrix (4, 4) from a file with this up axis and unit to the world in meters."""
    matrix = np.eye(4)
    matrix[:3, :3] = unit_m * np.array(_ROTATIONS[axis])
    return matrix


def _transform_motion(motion: Motion, change: Array) -> Motion:
    """Return the motion with each matrix multiplied by `change` (4, 4) from the left."""
    return lambda frame: np.asarray(change @ motion(frame))


def _likely_axis(path: Path) -> WorldAxis:
    """Return the likely up axis: z for STL, as in CAD, and for a PLY of Blender; else y."""
    suffix = path.suffix.lower()
    is_z_up = suffix == ".stl" or (suffix == ".ply" and _is_of_blender(path))
    return WorldAxis.Z if is_z_up else WorldAxis.Y


def _is_of_blender(path: Path) -> bool:
    """Return True for a file whose first lines name Blender, which writes meters."""
    with open_regular_file(path) as file:
        return b"Blender" in file.read(_HEAD_BYTES)


def _likely_unit_m(path: Path, size: float) -> float:
    """Return the unit in meters in which a scene of this `size` has a plausible size."""
    if _is_of_blender(path):
        return 1.0
    return next((unit_m for least, unit_m in _UNITS[path.suffix.lower()] if size > least), 1.0)


def _guess_notes(path: Path, framing: Framing, chosen_placing: Placing, size: float) -> list[str]:
    """Return a note on the guessed values, or none; `size` is that of the scene in its own unit."""
    guesses = []
    if chosen_placing.up_axis is None:
        guesses.append(f"{framing.up_axis} is taken as up; change it with --up-axis")
    if chosen_placing.meters_per_unit is None:
        unit_m = framing.meters_per_unit
        guesses.append(
            f"its unit is taken as {_NAMES[unit_m]}, which makes it {size * unit_m:.3g} m large; "
            "change it with --meters-per-unit"
        )
    return [f"{path} has no unit and no up axis: {', and '.join(guesses)}."] if guesses else []
