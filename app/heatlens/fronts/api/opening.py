"""Open a file or arrays for rendering."""

import os
from dataclasses import dataclass, replace
from typing import Unpack

from numpy.typing import ArrayLike

from heatlens.core.base.errors import InputError
from heatlens.core.model.option import Values
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.api.arguments import (
    check_names,
    check_pair,
    check_text,
    check_values,
    is_single,
    short_repr,
)
from heatlens.fronts.api.keywords import ReadingOptions
from heatlens.fronts.api.notes import errors_with_python_names
from heatlens.fronts.api.source import Source
from heatlens.fronts.api.source_kinds import OnePlate, Plates, Scene
from heatlens.media.documents.shot_file import is_shot_file, read_shot
from heatlens.media.plate.estimate.trusted import trust
from heatlens.media.plate.of_arrays import plate_of_arrays
from heatlens.media.plate.plate import Plate
from heatlens.media.scene.first_shot import first_shot
from heatlens.media.scene.placing import place_scene
from heatlens.media.sequence.sequence_search import find_sequence
from heatlens.render.source.kinds import kind_of
from heatlens.render.source.live_focus import measure_followed_marks
from heatlens.render.source.named import make_plate_source
from heatlens.render.source.plate_source import PlateSource


@dataclass(frozen=True)
class OpenArguments:
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
    `source` may also be an array: color (H, W, 3 or 4), scene-linear and premultiplied, with
    `depth_m` (H, W) in planar meters, infinite where nothing was hit, or with `coc_px` (H, W), the
    signed diameter of the circle of confusion in pixels. `camera` and `size` (width, height) are
    for scenes. `reading` takes the fields of `PlateOptions`: depth_channel, depth_convention,
    scene_unit_m and so on. `strict` is for arrays too: it makes the doubts of which `render` would
    warn errors.

    Raises HeatlensError with what was found and what would help.
    """
    with errors_with_python_names():
        check_names("open", reading)
        options = check_values(PlateOptions, reading)
        if not isinstance(source, str | os.PathLike):
            is_strict = options.pop("strict", False)
            _refuse_arguments("an array", camera=camera, size=size, **options)
            return OnePlate(_plate_of_arrays(source, depth_m, coc_px), is_strict)
        _refuse_arguments("a file", depth_m=depth_m, coc_px=coc_px)
        name = check_text("source", source)
        opened = _open_name(name, camera, size, options)
        opened.set_name(name, {**options, "scene_camera": camera, "size": size})
        return opened


def _plate_of_arrays(
    color: ArrayLike, depth_m: ArrayLike | None, coc_px: ArrayLike | None
) -> Plate:
    """Return the plate of arrays. Raises InputError for other objects."""
    if is_single(color):
        raise InputError(
            "heatlens.open takes the name of a file, or an array of colours with depth_m or "
            f"coc_px beside it, got {short_repr(color)}."
        )
    return plate_of_arrays(color, depth_m, coc_px)


def _open_name(
    name: str, camera: str | None, size: tuple[int, int] | None, options: dict[str, object]
) -> Source:
    """Return the source called `name`. Raises InputError for arguments of another kind."""
    arguments = OpenArguments(camera, size, options)
    if kind_of(name).reads_plates and is_shot_file(name):
        _refuse_arguments("plates", camera=camera, size=size)
        _refuse_arguments("a shot file, which says how its plates are read", **options)
        shot = measure_followed_marks(read_shot(name))
        if shot.source is None:
            raise InputError(
                f"{name} names no plates and no scene: give a file, a pattern such as "
                "plate.####.exr, or demo."
            )
        return _open_kind(shot.source, replace(arguments, shot=shot))
    return _open_kind(name, arguments)


def _open_kind(name: str, arguments: OpenArguments) -> Source:
    """Open a scene or plates, depending on the kind of the file."""
    source: Source = kind_of(name).python(name, arguments)
    return source


def open_scene(name: str, arguments: OpenArguments) -> Source:
    """Open a scene; a shot file gives its placement and camera. See `SourceKind.python`."""
    _refuse_arguments("a scene", **arguments.options)
    shot = arguments.shot
    if shot is not None:
        scene_shot = first_shot(name, timing=None if shot.framing is None else shot.framing.timing)
        scene = place_scene(scene_shot.scene, shot.framing)
        return Scene(replace(scene_shot, scene=scene, shot=shot, assumed=frozenset()), name)
    size_px = (
        None
        if arguments.size is None
        else check_pair("size", "a size (width, height)", arguments.size)
    )
    camera = None if arguments.camera is None else check_text("camera", arguments.camera)
    return Scene(first_shot(name, size_px, camera), name)


def open_plates(name: str, arguments: OpenArguments) -> Source:
    """Open plates, which are read as the options or the shot say. See `SourceKind.python`."""
    _refuse_arguments("plates", camera=arguments.camera, size=arguments.size)
    if arguments.shot is not None:
        return Plates(make_plate_source(name, arguments.shot.plate_options), arguments.shot)
    sequence = find_sequence(name, whole=False)
    options = PlateOptions(**arguments.options)
    options.refuse_estimate_without_network()
    trust(options.depth_model)
    return Plates(PlateSource(name, sequence, options), None)


def _refuse_arguments(source_kind: str, **arguments: object) -> None:
    """Raise InputError for arguments that have a value but no effect on this kind of source."""
    names = [name for name, value in arguments.items() if value is not None]
    if names:
        raise InputError(f"The source is {source_kind}: leave {', '.join(names)} out.")
