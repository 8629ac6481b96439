"""Open a file or arrays for rendering."""

import os
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from numpy.typing import ArrayLike

from heatlens.api.source import OnePlate, Plates, Scene, Source, check_names
from heatlens.documents.shot_file import is_shot_file, read_shot
from heatlens.errors import InputError
from heatlens.model.plate_options import PlateOptions
from heatlens.model.shot import Shot
from heatlens.plate.of_arrays import plate_of_arrays
from heatlens.scene.first_shot import first_shot
from heatlens.scene.placing import placed
from heatlens.source.kind import SourceKind, kind_of
from heatlens.source.named import plates_named


def open(
    source: str | os.PathLike[str] | ArrayLike,
    depth_m: ArrayLike | None = None,
    *,
    coc_px: ArrayLike | None = None,
    camera: str | None = None,
    size: tuple[int, int] | None = None,
    **reading: Any,
) -> Source:
    """Open what `source` names: a plate (EXR), shot.####.exr, a scene, "demo" or a shot file.

    Or an array: colour (H, W, 3 or 4), scene-linear and premultiplied, with `depth_m` (H, W) in
    planar metres, infinite where nothing was hit, or with `coc_px` (H, W), the signed diameter of
    the circle of confusion in pixels. `camera` and `size` (width, height) are for scenes. `reading`
    takes the fields of `PlateOptions`: depth_channel, depth_convention, scene_unit_m and so on.

    Raises HeatlensError with what was found and what would help.
    """
    if not isinstance(source, str | os.PathLike):
        _refuse("an array", camera=camera, size=size, **reading)
        return OnePlate(plate_of_arrays(source, depth_m, coc_px))
    text = os.fspath(source)
    _refuse("a file", depth_m=depth_m, coc_px=coc_px)
    if kind_of(text) is SourceKind.SCENE:
        _refuse("a scene", **reading)
        return Scene(first_shot(text, size, camera), text)
    _refuse("plates", camera=camera, size=size)
    if is_shot_file(text):
        _refuse("a shot file, which says how its plates are read", **reading)
        return _of_shot(read_shot(text), text)
    return Plates(plates_named(text, _plate_options(reading)), None)


def _of_shot(shot: Shot, text: str) -> Source:
    if shot.source is None:
        raise InputError(f"{text} names no plates and no scene.")
    if kind_of(shot.source) is SourceKind.SCENE:
        timing = None if shot.framing is None else shot.framing.timing
        begun = first_shot(shot.source, timing=timing)
        scene = placed(begun.scene, shot.framing)
        begun = replace(begun, scene=scene, shot=shot, assumed=frozenset())
        return Scene(begun, shot.source)
    return Plates(plates_named(shot.source, shot.plate_options), shot)


def _plate_options(reading: Mapping[str, Any]) -> PlateOptions:
    check_names(reading, PlateOptions)
    return PlateOptions(**reading)


def _refuse(what: str, **given: Any) -> None:
    """Raise InputError for values that would have no effect."""
    names = [name for name, value in given.items() if value is not None]
    if names:
        raise InputError(f"The source is {what}: leave {', '.join(names)} out.")
