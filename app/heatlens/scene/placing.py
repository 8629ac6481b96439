"""Which way is up in a scene and how long its unit is, where its file does not say.

PLY, STL and OBJ are numbers without a unit or a direction. A shot says for its scene what they mean
(`Framing.up_axis`, `Framing.meters_per_unit`); a first shot guesses it, and says so.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from heatlens.errors import InputError
from heatlens.model.framing import Framing, WorldAxis
from heatlens.scene.scene import Array, Motion, Scene
from heatlens.scene.scene_bounds import bounds_m

UNTOLD_SUFFIXES = (".obj", ".ply", ".stl")
_HEAD_BYTES = 400  # hold the first lines of any of them
# By format: above these sizes of a whole file, in its own unit, it is taken for that unit.
_UNITS = {
    ".stl": ((5.0, 1e-3),),
    ".obj": ((5000.0, 1e-3), (100.0, 1e-2)),
    ".ply": ((100.0, 1e-3),),
}
_NAMES = {1.0: "metres", 1e-2: "centimetres", 1e-3: "millimetres"}
# Columns: where x, y and z of a file go, so that its axis is up and the rest a rotation.
_TURNS = {
    WorldAxis.X: ((0, -1, 0), (1, 0, 0), (0, 0, 1)),
    WorldAxis.Y: ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    WorldAxis.Z: ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
}


@dataclass(frozen=True)
class Placing:
    """What somebody says of a file that does not say it; None where it is to be guessed."""

    up_axis: WorldAxis | None = None
    meters_per_unit: float | None = None


def is_untold(scene: Scene) -> bool:
    """Return True for a scene whose file says neither its unit nor which way is up."""
    return scene.path.suffix.lower() in UNTOLD_SUFFIXES


def placed_first(scene: Scene, framing: Framing, told: Placing) -> tuple[Scene, Framing]:
    """Return the scene and the framing with what was told, and guesses for the rest, with a note.

    Raises InputError where something was told of a file that says it itself.
    """
    if not is_untold(scene):
        if told != Placing():
            raise InputError(
                f"{scene.path} says its unit and which way is up: leave --up-axis and "
                "--meters-per-unit out."
            )
        return scene, framing
    axis, unit_m = told.up_axis or _likely_axis(scene.path), told.meters_per_unit
    size = float(np.ptp(bounds_m(scene, 1), axis=0).max())
    unit_m = unit_m or _likely_unit_m(scene.path, size)
    framing = replace(framing, up_axis=axis, meters_per_unit=unit_m)
    notes = (*scene.notes, *_guesses(scene.path, framing, told, size))
    return replace(placed(scene, framing), notes=notes), framing


def placed(scene: Scene, framing: Framing | None) -> Scene:
    """Return the scene with the axis of the framing upwards, in metres by the framing's unit."""
    wanted = framing or Framing()
    now = (scene.up_axis, scene.meters_per_unit)
    if not is_untold(scene) or now == (wanted.up_axis, wanted.meters_per_unit):
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
    """Return z for STL, which is of CAD and printing, and for a PLY that Blender wrote; else y."""
    suffix = path.suffix.lower()
    is_z_up = suffix == ".stl" or (suffix == ".ply" and _is_of_blender(path))
    return WorldAxis.Z if is_z_up else WorldAxis.Y


def _is_of_blender(path: Path) -> bool:
    """Return True for a file whose first lines name Blender, which writes metres."""
    with path.open("rb") as file:
        return b"Blender" in file.read(_HEAD_BYTES)


def _likely_unit_m(path: Path, size: float) -> float:
    """Return the unit with which things of this size, in the unit, have a likely size."""
    if _is_of_blender(path):
        return 1.0
    return next((unit_m for least, unit_m in _UNITS[path.suffix.lower()] if size > least), 1.0)


def _guesses(path: Path, framing: Framing, told: Placing, size: float) -> list[str]:
    found = []
    if told.up_axis is None:
        found.append(f"{framing.up_axis} is taken as up; --up-axis says otherwise")
    if told.meters_per_unit is None:
        unit_m = framing.meters_per_unit
        found.append(
            f"its unit is taken as {_NAMES[unit_m]}, so that it is {size * unit_m:.3g} m large; "
            "--meters-per-unit says otherwise"
        )
    return [f"{path}: the file does not say it: {', and '.join(found)}."] if found else []
