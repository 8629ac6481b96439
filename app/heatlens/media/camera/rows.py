"""Convert a camera to rows for each frame and back; read and write the rows as JSON and as a table.

A table (CSV) has a row for each frame, and units in the names of its columns.
"""

import csv
import io
import json
import math
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import file_bytes, unreadable
from heatlens.core.model.lens.lens import LensModel
from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.core.model.option import Values
from heatlens.media.camera.placement import Matrix, matrix_of
from heatlens.media.camera.samples import LENS_TRACKS, CameraSamples, fields_of
from heatlens.media.files.json_record import JsonEntry, plain, read_json

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


_RATE = "frames_per_second"
_UP = "up_axis"
_WORDS = (_UP, _MODEL, _IMAGE)  # columns that hold no number
# Row by row, acting on columns in metres.
_CELLS = tuple(f"{PLACEMENT}_{row}{column}" for row in range(4) for column in range(4))
_COLUMNS = (FRAME, *LENS_TRACKS, _RATE, *_WORDS, *_CELLS)


def csv_text(camera: CameraSamples) -> str:
    """Return the table as text, a row for each frame; infinity is written "inf"."""
    rows = [_written(camera, row) for row in rows_of(camera)]
    text = io.StringIO()
    writer = csv.DictWriter(text, rows[0], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def read_csv_camera(path: Path) -> CameraSamples:
    """Read a camera from a CSV file with its columns in any order.

    Raises InputError that names the damaged line.
    """
    try:
        text = file_bytes(path).decode("utf-8-sig")
        reader = csv.DictReader(io.StringIO(text, newline=""), strict=True)
        table = [(reader.line_num, row) for row in reader]
    except OSError as error:
        raise unreadable(path, error) from error
    except (ValueError, csv.Error) as error:
        raise InputError(f"{path} is damaged: {error}.") from error
    _check_columns(path, reader.fieldnames or ())
    if not table:
        raise InputError(f"{path} has no rows: a camera needs at least one frame.")
    rows = [_row_of_cells(path, line, cells) for line, cells in table]
    others = {name: rows[0][name] for name in (_RATE, *_WORDS) if name in rows[0]}
    if _MODEL in others:
        others[_MODEL] = _model(path, others[_MODEL])
    if _IMAGE in others:
        others[_IMAGE] = OpeningImage(others[_IMAGE])
    try:
        return camera_of_rows(rows, name=path.stem, **others)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _written(camera: CameraSamples, row: Row) -> dict[str, object]:
    cells = {name: value for name, value in row.items() if name != PLACEMENT}
    cells |= {_RATE: camera.frames_per_second, _UP: camera.up_axis}
    if camera.lens_model is not None:
        cells[_MODEL] = camera.lens_model
    if camera.aperture_image is not None:
        cells[_IMAGE] = camera.aperture_image.path
    if PLACEMENT in row:
        numbers = (number for line in row[PLACEMENT] for number in line)
        cells |= dict(zip(_CELLS, numbers, strict=True))
    return cells


def _check_columns(path: Path, names: Sequence[str]) -> None:
    for name in names:
        if name not in _COLUMNS:
            near = get_close_matches(str(name), _COLUMNS, 1)
            hint = f"did you mean {near[0]!r}?" if near else f"known are {', '.join(_COLUMNS[:9])}"
            raise InputError(f"{path}: unknown column {name!r}; {hint}")
        if list(names).count(name) > 1:
            raise InputError(f"{path}: the column {name!r} occurs twice.")


def _row_of_cells(path: Path, line: int, cells: Mapping[str | None, str]) -> Values:
    """Return the values of a line by the names of their columns, without the empty cells."""
    if None in cells or None in cells.values():
        raise InputError(f"{path}: line {line} has more or fewer cells than there are columns.")
    texts = {str(name): text.strip() for name, text in cells.items() if text.strip()}
    row: Values = {
        name: text if name in _WORDS else _number(path, line, name, text)
        for name, text in texts.items()
    }
    if FRAME in row:
        row[FRAME] = _whole(path, line, row[FRAME])
    if any(name in row for name in _CELLS):
        row[PLACEMENT] = _matrix(path, line, row)
    return row


def _model(path: Path, text: str) -> LensModel:
    if text not in list(LensModel):
        known = " or ".join(LensModel)
        raise InputError(f"{path}: {_MODEL} should be {known}, got {text!r}.")
    return LensModel(text)


def _number(path: Path, line: int, name: str, text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if math.isnan(number):
        raise InputError(f"{path}: line {line}: {name} should be a number, got {text!r}.")
    return number


def _whole(path: Path, line: int, frame: float) -> int:
    if not frame.is_integer():
        raise InputError(f"{path}: line {line}: a frame should be a whole number, got {frame:g}.")
    return int(frame)


def _matrix(path: Path, line: int, row: Row) -> Matrix:
    missing = [name for name in _CELLS if name not in row]
    if missing:
        raise InputError(f"{path}: line {line}: the placement lacks {missing[0]}.")
    cells = [row[name] for name in _CELLS]
    return matrix_of([cells[at : at + 4] for at in range(0, 16, 4)])
