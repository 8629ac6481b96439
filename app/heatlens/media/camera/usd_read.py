"""Read a camera from a USD stage, in any of its formats."""

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange, check_frame
from heatlens.core.model.lens.lens import LensModel
from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.media.camera.placement import Matrix, matrix_of, shortest_decimal
from heatlens.media.camera.samples import INFINITE_M, CameraSamples, Track, UpAxis, fields_of
from heatlens.media.camera.usd_write import (
    APERTURE_IMAGE,
    LENS_MODEL,
    MM_ATTRIBUTES,
    NOMINAL_F_STOP,
    OPENING,
    SQUEEZE,
    units_per_mm,
)
from heatlens.media.files.quiet import quiet_library
from heatlens.media.files.usd_library import (
    UsdObject,
    lens_unit_mm,
    lens_unit_note,
    open_usd,
    read_usd_in_process,
    report_usd_failures,
    usd_module,
)
from heatlens.media.plate.header.placement import are_rigid

USD_SUFFIXES = (".usd", ".usda", ".usdc", ".usdz")

_AND_PRIM = re.compile(r"(.+\.usd[acz]?):(/.*)", re.IGNORECASE | re.DOTALL)
_ATTRIBUTES = (
    *MM_ATTRIBUTES.values(),
    "focusDistance",
    "fStop",
    SQUEEZE,
    NOMINAL_F_STOP,
    *OPENING.values(),
)
_STILL_FRAME = 1
_LISTED_CAMERAS = 5
_INFINITE_SHARE = 0.999  # share of INFINITE_M, for rounding to float32 and another unit


@dataclass(frozen=True)
class _Stage:
    """An opened USD file, its unit, and the camera prim."""

    path: Path
    stage: UsdObject
    prim: UsdObject
    meters_per_unit: float


def split_prim(text: str) -> tuple[Path, str | None]:
    """Split `shot.usda:/world/cam` into file and prim path; None if no prim is named."""
    match = _AND_PRIM.fullmatch(text)
    return (Path(match[1]), match[2]) if match else (Path(text), None)


def read_usd_camera(text: str) -> CameraSamples:
    """Run `usd_camera` in a separate process, to survive a crash of OpenUSD.

    Raises InputError as `usd_camera` does, and where OpenUSD ends that process.
    """
    return read_usd_in_process(usd_camera, text, split_prim(text)[0])


def usd_camera(text: str) -> CameraSamples:
    """Read the camera of a file, or the one named in it as in `shot.usda:/world/cam`.

    A time code is a frame. USD writes an f-stop or a focus of 0 where nothing is out of focus; both
    count as unknown here. Raises InputError if the file is damaged, has no camera, or has
    several and none is named.
    """
    path, prim_path = split_prim(text)
    with quiet_library(), report_usd_failures(path):
        stage = _open_stage(path, prim_path)
        try:
            _check_projection(stage)
            frames = _frames(stage)
            placement, notes = _placement(stage, frames)
            unit_note = _lens_unit_note(stage, frames[0])
            notes = notes if unit_note is None else (*notes, unit_note)
            return CameraSamples(
                name=stage.prim.GetName(),
                frames=frames,
                **fields_of(_lens_values(stage, frames, unit_note)),
                lens_model=_lens_model(stage),
                aperture_image=_aperture_image(stage),
                world_to_camera=placement,
                up_axis=_up_axis(stage),
                frames_per_second=stage.stage.GetTimeCodesPerSecond(),
                notes=(f"{path}: the camera is {stage.prim.GetPath()}.", *notes),
            )
        except InputError as error:
            raise InputError(f"{path}: {stage.prim.GetPath()}: {error}") from None


def _open_stage(path: Path, prim_path: str | None) -> _Stage:
    """Open a USD file and choose its camera. Raises InputError."""
    usd_package, geometry = usd_module("Usd"), usd_module("UsdGeom")
    stage = open_usd(path)
    cameras = [prim for prim in _all_prims(usd_package, stage) if prim.IsA(geometry.Camera)]
    unit_m = geometry.GetStageMetersPerUnit(stage)
    if not 0 < unit_m < math.inf:
        raise InputError(
            f"{path} has {unit_m:g} metres per unit, so no length can be read: export it with "
            "metersPerUnit above 0."
        )
    return _Stage(path, stage, _choose_camera(path, cameras, prim_path), unit_m)


def _all_prims(usd_package: UsdObject, stage: UsdObject) -> Iterable[UsdObject]:
    """Return every prim of the stage, those within instances included."""
    prims: Iterable[object] = stage.Traverse(usd_package.TraverseInstanceProxies())
    return prims


def _choose_camera(path: Path, cameras: list[UsdObject], prim_path: str | None) -> object:
    """Return the camera at `prim_path`, or the only one; raise InputError that lists them."""
    by_path = {str(camera.GetPath()): camera for camera in cameras}
    if not by_path:
        raise InputError(f"{path} has no camera.")
    if prim_path in by_path:
        return by_path[prim_path]
    if prim_path is None and len(by_path) == 1:
        return cameras[0]
    camera_list = ", ".join(
        [*list(by_path)[:_LISTED_CAMERAS], *(["..."] if len(by_path) > _LISTED_CAMERAS else [])]
    )
    if prim_path is None:
        raise InputError(
            f"{path} has {len(by_path)} cameras: {camera_list}. Name one, as in "
            f"{path.name}:{next(iter(by_path))}"
        )
    raise InputError(f"{path} has no camera {prim_path}; it has {camera_list}.")


def _check_projection(stage: _Stage) -> None:
    """Raise InputError for an orthographic camera."""
    if stage.prim.GetAttribute("projection").Get() == "orthographic":
        raise InputError("the camera is orthographic, so it has no lens: name a perspective one.")


def _frames(stage: _Stage) -> tuple[int, ...]:
    """Return every whole frame within the time samples of lens and placement."""
    xformable = usd_module("UsdGeom").Xformable
    attributes = [stage.prim.GetAttribute(name) for name in _ATTRIBUTES]
    times = {time for attribute in attributes if attribute for time in attribute.GetTimeSamples()}
    times.update(
        time for prim in _transformable_prims(stage) for time in xformable(prim).GetTimeSamples()
    )
    if not times:
        return (_STILL_FRAME,)
    for time in (min(times), max(times)):
        check_frame(time)
    return tuple(FrameRange(math.floor(min(times)), math.ceil(max(times))))


def _lens_unit_note(stage: _Stage, frame: int) -> str | None:
    """Return a sentence if the file has lengths of the lens in mm, which USD does not allow.

    Returns None if they are in tenths of the stage's unit, as USD has them.
    """
    focal, width = (
        _track(stage, MM_ATTRIBUTES[name], (frame,))[0]
        for name in ("focal_length_mm", "sensor_width_mm")
    )
    unit_m = stage.meters_per_unit
    if math.isclose(lens_unit_mm(unit_m, focal, width), unit_m * 100):
        return None
    return lens_unit_note(stage.path, unit_m, focal)


def _lens_values(
    stage: _Stage, frames: tuple[int, ...], unit_note: str | None
) -> dict[str, UsdObject]:
    """Return the tracks of the lens; with a `unit_note`, lengths in the file are in mm."""
    file_units_per_mm = units_per_mm(stage.meters_per_unit) if unit_note is None else 1.0
    lengths: dict[str, Track | None] = {
        name: _track(stage, attribute, frames, file_units_per_mm)
        for name, attribute in MM_ATTRIBUTES.items()
    }
    focus = _track(stage, "focusDistance", frames, 1 / stage.meters_per_unit)
    return lengths | {
        "f_stop": _none_if_zero(_track(stage, "fStop", frames)),
        "focus_distance_m": _none_if_zero(tuple(map(_infinite_if_far, focus))),
        "squeeze": _heatlens_track(stage, SQUEEZE, frames),
        **{
            name: _heatlens_track(stage, attribute_name, frames)
            for name, attribute_name in OPENING.items()
        },
        "nominal_f_stop": _heatlens_track(stage, NOMINAL_F_STOP, frames),
    }


def _heatlens_track(stage: _Stage, name: str, frames: tuple[int, ...]) -> Track | None:
    """Return an attribute that only heatlens writes; None if it is not there."""
    return _track(stage, name, frames) if stage.prim.HasAttribute(name) else None


def _lens_model(stage: _Stage) -> LensModel | None:
    """Return the lens model that heatlens has written; None if it is missing or unknown."""
    attribute = stage.prim.GetAttribute(LENS_MODEL)
    name = attribute.Get() if attribute else None
    return LensModel(name) if name in list(LensModel) else None


def _aperture_image(stage: _Stage) -> OpeningImage | None:
    """Return the aperture image named in the file, not yet read; None if there is none."""
    attribute = stage.prim.GetAttribute(APERTURE_IMAGE)
    path = attribute.Get() if attribute else None
    return OpeningImage(path) if isinstance(path, str) and path else None


def _track(stage: _Stage, name: str, frames: tuple[int, ...], unit: float = 1.0) -> Track:
    """Return a numeric attribute at each frame, divided by `unit`. Raises InputError otherwise."""
    attribute = stage.prim.GetAttribute(name)
    values = [attribute.Get(frame) for frame in frames]
    for frame, value in zip(frames, values, strict=True):
        if not isinstance(value, float | int):
            raise InputError(f"{name} should be a number at frame {frame}, got {value!r}.")
    decimals = {
        value: shortest_decimal(value, unit) for value in dict.fromkeys(values)
    }  # most frames share a few values, so each value is converted once
    return tuple(decimals[value] for value in values)


def _none_if_zero(track: Track) -> Track | None:
    return track if any(track) else None


def _infinite_if_far(distance_m: float) -> float:
    return math.inf if distance_m >= INFINITE_M * _INFINITE_SHARE else distance_m


def _up_axis(stage: _Stage) -> UpAxis:
    axis = usd_module("UsdGeom").GetStageUpAxis(stage.stage)
    return "z" if axis == "Z" else "y"


def _placement(
    stage: _Stage, frames: tuple[int, ...]
) -> tuple[tuple[Matrix, ...] | None, tuple[str, ...]]:
    """Return the world-to-camera matrix of each frame in meters, and notes for the user.

    The scale of parent prims is removed. The placement is None where the file has none, or where it
    shears or mirrors.
    """
    geometry = usd_module("UsdGeom")
    if not any(
        geometry.Xformable(prim).GetOrderedXformOps() for prim in _transformable_prims(stage)
    ):
        return None, ()
    to_world = np.empty((len(frames), 4, 4))
    for frame_matrix, frame in zip(to_world, frames, strict=True):
        matrix = geometry.Xformable(stage.prim).ComputeLocalToWorldTransform(frame)
        matrix.Orthonormalize(issueWarning=False)
        frame_matrix[:] = np.array(matrix, np.float64).T
    to_world[:, :3, 3] *= stage.meters_per_unit
    if not (is_rigid := are_rigid(to_world)).all():
        frame = frames[int(np.argmin(is_rigid))]
        return None, (f"its transform at frame {frame} shears or mirrors, and is left out.",)
    return tuple(map(matrix_of, np.linalg.inv(to_world).tolist())), ()


def _transformable_prims(stage: _Stage) -> Iterable[object]:
    """Yield the camera and its ancestors as far as they can have a transform."""
    prim = stage.prim
    while prim and not prim.IsPseudoRoot():
        if prim.IsA(usd_module("UsdGeom").Xformable):
            yield prim
        prim = prim.GetParent()
