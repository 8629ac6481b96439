"""Open a file or arrays for rendering."""

import os
from dataclasses import dataclass, replace
from typing import Unpack

from numpy.typing import ArrayLike

from heatlens.core.base.errors import InputError
from heatlens.core.model.option import Values
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.api.arguments import check_names, is_single, pair, shown, text, values_of
from heatlens.fronts.api.keywords import ReadingOptions
from heatlens.fronts.api.notes import python_words
from heatlens.fronts.api.source import Source
from heatlens.fronts.api.source_kinds import OnePlate, Plates, Scene
from heatlens.media.documents.shot_file import is_shot_file, read_shot
from heatlens.media.plate.estimate.trusted import trust
from heatlens.media.plate.of_arrays import plate_of_arrays
from heatlens.media.plate.plate import Plate
from heatlens.media.scene.first_shot import first_shot
from heatlens.media.scene.placing import placed
from heatlens.media.sequence.sequence import find_sequence
from heatlens.render.source.kinds import kind_of
from heatlens.render.source.live_focus import measured
from heatlens.render.source.named import plates_again
from heatlens.render.source.plate_source import PlateSource


@dataclass(frozen=True)
class Asked:
    """The arguments of `open` besides the source, and the shot that a shot file holds."""

    camera: str | None
    size: tuple[int, int] | None
    options: Values
    shot: Shot | None = None


def open(
    source: "str | os.PathLike[str] | ArrayLike",  # quoted: numpy's type would fill the help
    depth_m: "ArrayLike | None" = None,
    *,
    coc_px: "ArrayLike | None" = None,
    camera: str | None = None,
    size: tuple[int, int] | None = None,
    **reading: Unpack[ReadingOptions],
) -> Source:
    """Open what `source` names: a plate (EXR), shot.####.exr, a scene, "demo" or a shot file.

    The name of a file opens that picture alone; shot.####.exr opens its sequence.
    `source` may also be an array: colour (H, W, 3 or 4), scene-linear and premultiplied, with
    `depth_m` (H, W) in planar metres, infinite where nothing was hit, or with `coc_px` (H, W), the
    signed diameter of the circle of confusion in pixels. `camera` and `size` (width, height) are
    for scenes. `reading` takes the fields of `PlateOptions`: depth_channel, depth_convention,
    scene_unit_m and so on, of which `strict` is for arrays too: with it, what `render` would warn
    of as doubtful is an error.

    Raises HeatlensError with what was found and what would help.
    """
    with python_words():
        check_names("open", reading)
        options = values_of(PlateOptions, reading)
        if not isinstance(source, str | os.PathLike):
            is_strict = options.pop("strict", False)
            _refuse("an array", camera=camera, size=size, **options)
            return OnePlate(_plate_of(source, depth_m, coc_px), is_strict)
        _refuse("a file", depth_m=depth_m, coc_px=coc_px)
        return _of_name(text("source", source), camera, size, options)


def _plate_of(color: ArrayLike, depth_m: ArrayLike | None, coc_px: ArrayLike | None) -> Plate:
    """Return the plate of arrays. Raises InputError for other objects."""
    if is_single(color):
        raise InputError(
            "heatlens.open takes the name of a file, or an array of colours with depth_m or "
            f"coc_px beside it, got {shown(color)}."
        )
    return plate_of_arrays(color, depth_m, coc_px)


def _of_name(
    name: str, camera: str | None, size: tuple[int, int] | None, options: dict[str, object]
) -> Source:
    """Return the source called `name`. Raises InputError for arguments of another kind."""
    asked = Asked(camera, size, options)
    if kind_of(name).reads_plates and is_shot_file(name):
        _refuse("plates", camera=camera, size=size)
        _refuse("a shot file, which says how its plates are read", **options)
        shot = measured(read_shot(name))
        if shot.source is None:
            raise InputError(f"{name} names no plates and no scene.")
        return _of_kind(shot.source, replace(asked, shot=shot))
    return _of_kind(name, asked)


def _of_kind(name: str, asked: Asked) -> Source:
    source: Source = kind_of(name).python(name, asked)
    return source


def scene_named(name: str, asked: Asked) -> Source:
    """Return a scene; a shot has its placement and its camera. See `SourceKind.python`."""
    _refuse("a scene", **asked.options)
    shot = asked.shot
    if shot is not None:
        begun = first_shot(name, timing=None if shot.framing is None else shot.framing.timing)
        scene = placed(begun.scene, shot.framing)
        return Scene(replace(begun, scene=scene, shot=shot, assumed=frozenset()), name)
    seen_px = None if asked.size is None else pair("size", "a size (width, height)", asked.size)
    seen_by = None if asked.camera is None else text("camera", asked.camera)
    return Scene(first_shot(name, seen_px, seen_by), name)


def plates_named(name: str, asked: Asked) -> Source:
    """Return plates, read as the options or the shot say. See `SourceKind.python`."""
    _refuse("plates", camera=asked.camera, size=asked.size)
    if asked.shot is not None:
        return Plates(plates_again(name, asked.shot.plate_options), asked.shot)
    alone = find_sequence(name, whole=False)
    options = PlateOptions(**asked.options)
    trust(options.depth_model)
    return Plates(PlateSource(name, alone, options), None)


def _refuse(what: str, **given: object) -> None:
    """Raise InputError for values that would have no effect."""
    names = [name for name, value in given.items() if value is not None]
    if names:
        raise InputError(f"The source is {what}: leave {', '.join(names)} out.")
