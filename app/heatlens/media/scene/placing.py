"""Set the up axis and the unit of a scene whose file does not define them.

PLY, STL and OBJ have no unit and no up axis. A shot holds them for its scene (`Framing.up_axis`,
`Framing.meters_per_unit`); a first shot guesses them and adds a note.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import opened_file
from heatlens.core.model.shot.framing import Framing, WorldAxis
from heatlens.media.scene.scene import Array, Motion, Scene
from heatlens.media.scene.scene_bounds import bounds_m

UNTOLD_SUFFIXES = (".obj", ".ply", ".stl")
_HEAD_BYTES = 400  # enough for the first lines of these formats
# By format: if a whole scene is larger than this number, its unit is guessed as the one beside it.
_UNITS = {
    ".stl": ((5.0, 1e-3),),
    ".obj": ((5000.0, 1e-3), (100.0, 1e-2)),
    ".ply": ((100.0, 1e-3),),
}
_NAMES = {1.0: "metres", 1e-2: "centimetres", 1e-3: "millimetres"}
# The columns are the images of x, y and z of a file, a rotation that turns its up axis upwards.
_TURNS = {
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
    return scene.path.suffix.lower() in UNTOLD_SUFFIXES


def placed_first(scene: Scene, framing: Framing, chosen: Placing) -> tuple[Scene, Framing]:
    """Return the scene and the framing with the chosen values, and noted guesses for the rest.

    Raises InputError if values are given for a file that defines them itself.
    """
    if not lacks_placing(scene):
        if chosen != Placing():
            raise InputError(
                f"{scene.path} defines its own unit and up axis: leave --up-axis and "
                "--meters-per-unit out."
            )
        return scene, framing
    axis, unit_m = chosen.up_axis or _likely_axis(scene.path), chosen.meters_per_unit
    size = float(np.ptp(bounds_m(scene, 1), axis=0).max())
    unit_m = unit_m or _likely_unit_m(scene.path, size)
    framing = replace(framing, up_axis=axis, meters_per_unit=unit_m)
    notes = (*scene.notes, *_guesses(scene.path, framing, chosen, size))
    return replace(placed(scene, framing), notes=notes), framing


def placed(scene: Scene, framing: Framing | None) -> Scene:
    """Return the scene turned to the framing's up axis, and scaled to metres by its unit."""
    wanted = framing or Framing()
    now = (scene.up_axis, scene.meters_per_unit)
    if not lacks_placing(scene) or now == (wanted.up_axis, wanted.meters_per_unit):
        return scene
    change = _matrix(wanted.up_axis, wanted.meters_per_unit) @ np.linalg.inv(_matrix(*now))
    return replace(
        scene,
        instances=tuple(
            replace(instance, to_world=change @ instance.to_world) for instance in scene.instances
        ),
        motion=None if scene.motion is None else _moved(scene.motion, change),
        up_axis=wanted.up_axis,
        meters_per_unit=wanted.meters_per_unit,
    )


def _matrix(axis: WorldAxis, unit_m: float) -> Array:
    matrix = np.eye(4)
    matrix[:3, :3] = unit_m * np.array(_TURNS[axis])
    return matrix


def _moved(motion: Motion, change: Array) -> Motion:
    return lambda frame: np.asarray(change @ motion(frame))


def _likely_axis(path: Path) -> WorldAxis:
    """Return z for STL, used in CAD and 3D printing, and for a PLY of Blender; else y."""
    suffix = path.suffix.lower()
    is_z_up = suffix == ".stl" or (suffix == ".ply" and _is_of_blender(path))
    return WorldAxis.Z if is_z_up else WorldAxis.Y


def _is_of_blender(path: Path) -> bool:
    """Return True for a file whose first lines name Blender, which writes metres."""
    with opened_file(path) as file:
        return b"Blender" in file.read(_HEAD_BYTES)


def _likely_unit_m(path: Path, size: float) -> float:
    """Return the unit in metres in which a scene of this `size` has a plausible size."""
    if _is_of_blender(path):
        return 1.0
    return next((unit_m for least, unit_m in _UNITS[path.suffix.lower()] if size > least), 1.0)


def _guesses(path: Path, framing: Framing, chosen: Placing, size: float) -> list[str]:
    guesses = []
    if chosen.up_axis is None:
        guesses.append(f"{framing.up_axis} is taken as up; change it with --up-axis")
    if chosen.meters_per_unit is None:
        unit_m = framing.meters_per_unit
        guesses.append(
            f"its unit is taken as {_NAMES[unit_m]}, which makes it {size * unit_m:.3g} m large; "
            "change it with --meters-per-unit"
        )
    return [f"{path} has no unit and no up axis: {', and '.join(guesses)}."] if guesses else []
