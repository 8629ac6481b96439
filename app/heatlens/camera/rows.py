"""Convert a camera to rows for each frame, which JSON and CSV files hold, and back; JSON itself."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from heatlens.base.errors import InputError
from heatlens.camera.placement import matrix_of
from heatlens.camera.samples import LENS_TRACKS, CameraSamples, fields_of
from heatlens.files.json_record import JsonEntry, plain, read_json
from heatlens.model.lens.lens_model import LensModel
from heatlens.model.lens.opening_image import OpeningImage

FRAME = "frame"
PLACEMENT = "world_to_camera"

Row = Mapping[str, Any]
CAMERA_VERSION = 1

_VERSION = "heatlens_camera"
_CONVENTIONS = (
    "names end in their units; world_to_camera is row-major, acts on column vectors in metres; "
    "the camera looks along -z with x to the right and y up"
)
_MODEL = "lens_model"
_IMAGE = "aperture_image"
_TOP = (_VERSION, "conventions", "name", "frames_per_second", "up_axis", _MODEL, _IMAGE, "samples")


def rows_of(camera: CameraSamples) -> list[Row]:
    """Return a row for each frame: its number, the known lens values and the matrix."""
    columns: dict[str, Sequence[object]] = {FRAME: camera.frames, **camera.lens_tracks}
    if camera.world_to_camera is not None:
        columns[PLACEMENT] = camera.world_to_camera
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def camera_of_rows(rows: Sequence[Row], **others: Any) -> CameraSamples:
    """Return the camera of rows; raise InputError if only some rows have a value."""
    for row in rows:
        if FRAME not in row:
            raise InputError(f"Row {rows.index(row) + 1} has no frame number.")
    columns: dict[str, object] = {name: _column(rows, name) for name in (*LENS_TRACKS, PLACEMENT)}
    frames = tuple(row[FRAME] for row in rows)
    return CameraSamples(frames=frames, **fields_of(columns), **others)


def _column(rows: Sequence[Row], name: str) -> tuple[object, ...] | None:
    missing = [row for row in rows if name not in row]
    if len(missing) == len(rows):
        return None
    if missing:
        raise InputError(f"Frame {missing[0][FRAME]} has no {name}, but other frames do.")
    return tuple(row[name] for row in rows)


def json_text(camera: CameraSamples) -> str:
    """Return the JSON text, one frame in each line."""
    top = {
        _VERSION: CAMERA_VERSION,
        "conventions": _CONVENTIONS,
        "name": camera.name,
        "frames_per_second": plain(camera.frames_per_second),
        "up_axis": camera.up_axis,
        **({} if camera.lens_model is None else {_MODEL: camera.lens_model}),
        **({} if camera.aperture_image is None else {_IMAGE: camera.aperture_image.path}),
    }
    lines = [f"  {json.dumps(name)}: {json.dumps(value)}," for name, value in top.items()]
    samples = (
        json.dumps({name: plain(value) for name, value in row.items()}) for row in rows_of(camera)
    )
    body = ",\n".join(f"    {sample}" for sample in samples)
    return "\n".join(["{", *lines, '  "samples": [', body, "  ]", "}"]) + "\n"


def read_json_camera(path: Path) -> CameraSamples:
    """Read a camera; raise InputError that names the damaged entry."""
    top = read_json(path)
    top.check_version(_VERSION, CAMERA_VERSION, "camera")
    entries = top.members(_TOP, ["samples"])
    others: dict[str, object] = {
        "rows": [_row(item) for item in entries["samples"].items()],
        "name": entries["name"].text() if "name" in entries else path.stem,
    }
    if "frames_per_second" in entries:
        others["frames_per_second"] = entries["frames_per_second"].number()
    if "up_axis" in entries:
        others["up_axis"] = entries["up_axis"].choice(("y", "z"))
    if _MODEL in entries:
        others[_MODEL] = entries[_MODEL].of_type(LensModel)
    if _IMAGE in entries:
        others[_IMAGE] = entries[_IMAGE].of_type(OpeningImage)
    return top.built(camera_of_rows, others)


def _row(item: JsonEntry) -> Row:
    """Return the values of a frame by the names of the tracks."""
    entries = item.members((FRAME, *LENS_TRACKS, PLACEMENT))
    row: dict[str, object] = {
        name: entries[name].number() for name in LENS_TRACKS if name in entries
    }
    if FRAME in entries:
        row[FRAME] = entries[FRAME].whole()
    if PLACEMENT in entries:
        matrix = [[value.number() for value in line.items()] for line in entries[PLACEMENT].items()]
        row[PLACEMENT] = entries[PLACEMENT].built(matrix_of, {"rows": matrix})
    return row
