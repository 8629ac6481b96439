"""Read and write camera files; the extension decides the format."""

import os
import re
from dataclasses import replace
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.media.camera.blender_write import blender_text
from heatlens.media.camera.nuke_write import nuke_text, unsupported_note
from heatlens.media.camera.plate_camera import read_plate_camera
from heatlens.media.camera.rows import csv_text, json_text, read_csv_camera, read_json_camera
from heatlens.media.camera.samples import CameraSamples, UpAxis
from heatlens.media.camera.shoot_table import is_shoot_table, read_shoot_table, table_columns
from heatlens.media.camera.usd_read import USD_SUFFIXES, read_usd_camera, split_prim
from heatlens.media.camera.usd_write import METERS_PER_UNIT, usd_bytes
from heatlens.media.documents.shot_file import SHOT_SUFFIX
from heatlens.media.files.atomic_file import write_atomically
from heatlens.media.plate.opening_picture import read_relative_image, with_relative_path

CAMERA_SUFFIXES = (".usda", ".usd", ".usdc", ".nk", ".json", ".csv", ".py")

# The formats that heatlens also reads. They hold the path of an aperture image relative to the
# file. Others hold it absolute, because they are pasted anywhere.
_WITH_RELATIVE_IMAGE = (*USD_SUFFIXES, ".json", ".csv")
# The table of a shoot with the frame of its first row, as in `take.csv@1001`.
_AT_FRAME = re.compile(r"(.+\.csv)@(-?[0-9]{1,9})", re.IGNORECASE)
_WITH_UNIT = (".usda", ".usd", ".usdc", ".nk")
_UNIT_LEAST, _UNIT_MOST = 1e-6, 1e6  # meters; beyond them float32 cannot hold a lens and infinity


def write_camera(
    path: str | os.PathLike[str],
    camera: CameraSamples,
    meters_per_unit: float | None = None,
    holds_inverse: bool = False,
) -> None:
    """Write a camera in the format of the file's extension.

    The file is written beside `path` and renamed into place, so that an earlier one stays until the
    new one is complete. `meters_per_unit` is the unit of the scene that the camera is for; None
    means 0.01 for USD and 1 for Nuke, and the other formats are always in meters. `holds_inverse`
    means that the depth of the plate is 1/z, for which a file for Nuke has a node.

    Raises InputError if the extension is not known or the file cannot be written.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in CAMERA_SUFFIXES or path.name.lower().endswith(SHOT_SUFFIX):
        raise InputError(f"{path}: the name of a camera must end in {', '.join(CAMERA_SUFFIXES)}.")
    if meters_per_unit is not None:
        _check_unit(path, meters_per_unit)
    image = camera.aperture_image
    if image is not None and suffix in _WITH_RELATIVE_IMAGE:
        camera = replace(camera, aperture_image=with_relative_path(image, path.parent))
    data = _encode_camera(suffix, camera, meters_per_unit, holds_inverse)
    write_atomically(path, data)


def unsupported_notes(path: str | os.PathLike[str], camera: CameraSamples) -> tuple[str, ...]:
    """Return sentences on features of the camera that the target program does not support."""
    note = unsupported_note(camera) if Path(path).suffix.lower() == ".nk" else ""
    return (note,) if note else ()


def read_camera(
    text: str, scene_unit_m: float = 1.0, up_axis: UpAxis = "y", focus_unit_m: float | None = None
) -> CameraSamples:
    """Read the camera that `text` names: the path of a file, with a suffix for some formats.

    It is a USD file, with the camera's path where it holds several (`shot.usda:/world/cam`), JSON
    or CSV as `write_camera` writes them, the CSV of a shoot, or a plate with its EXR headers.
    `take.csv@1001` puts the first row of a shoot at frame 1001.

    Headers do not define the unit and the up axis of their world: `scene_unit_m` is the unit in
    meters, `up_axis` the axis. `focus_unit_m` is the unit of the focus in the table of a shoot, if
    it was given.

    Raises InputError if there is no camera, the file is damaged, or an aperture image that it
    names cannot be read.
    """
    path, _ = split_prim(text)
    if (table := _find_shoot_table(text, path)) is not None:
        return read_shoot_table(*table, focus_unit_m)
    if focus_unit_m is not None:
        raise InputError(
            f"{text} is not the table of a shoot, which --table-unit is for: leave it out."
        )
    camera = _read_by_suffix(text, path, scene_unit_m, up_axis)
    if camera.aperture_image is None:
        return camera
    try:
        image = read_relative_image(camera.aperture_image, path.parent)
    except InputError as error:
        raise InputError(f"{path}: the aperture image that it names: {error}") from None
    return replace(camera, aperture_image=image)


def _read_by_suffix(text: str, path: Path, scene_unit_m: float, up_axis: UpAxis) -> CameraSamples:
    """Return the camera of `text`, whose file is `path`; an image that it names is not read."""
    suffix = path.suffix.lower()
    if suffix in USD_SUFFIXES:
        return read_usd_camera(text)
    if suffix == ".json":
        return read_json_camera(path)
    if suffix == ".csv":
        return read_csv_camera(path)
    if suffix in (".nk", ".py"):
        raise InputError(
            f"{path}: heatlens writes cameras of this kind but cannot read them. Use USD."
        )
    return read_plate_camera(text, scene_unit_m, up_axis)


def _find_shoot_table(text: str, path: Path) -> tuple[Path, int | None] | None:
    """Return the table of a shoot and the frame of its first row; None for other cameras."""
    if (match := _AT_FRAME.fullmatch(text)) is not None:
        return Path(match[1]), int(match[2])
    if path.suffix.lower() != ".csv":
        return None
    try:
        column_names = table_columns(path)
    except InputError:  # `read_csv_camera` reports the problem
        return None
    return (path, None) if is_shoot_table(column_names) else None


def _check_unit(path: Path, meters_per_unit: float) -> None:
    """Raise InputError if the format takes no unit, or for an impossible one."""
    if path.suffix.lower() not in _WITH_UNIT:
        raise InputError(f"{path}: this format is always in metres: leave --meters-per-unit out.")
    if not _UNIT_LEAST <= meters_per_unit <= _UNIT_MOST:
        raise InputError(
            f"A scene has {_UNIT_LEAST:g} to {_UNIT_MOST:g} metres per unit, not "
            f"{meters_per_unit:g}."
        )


def _encode_camera(
    suffix: str, camera: CameraSamples, meters_per_unit: float | None, holds_inverse: bool
) -> bytes:
    """Return the content of a camera file with this extension."""
    if suffix in USD_SUFFIXES:
        return usd_bytes(camera, suffix, meters_per_unit or METERS_PER_UNIT)
    if suffix == ".nk":
        return nuke_text(camera, meters_per_unit or 1.0, holds_inverse).encode()
    text = {".json": json_text, ".csv": csv_text, ".py": blender_text}[suffix](camera)
    # A name that is not Unicode cannot be UTF-8; JSON and Python read its escape back.
    return text.encode("utf-8", "backslashreplace")
