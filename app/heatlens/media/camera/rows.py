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
from heatlens.core.base.paths import read_file_bytes, unreadable_error
from heatlens.core.model.lens.lens import LensModel
from heatlens.core.model.lens.opening_image import OpeningImage
from heatlens.core.model.option import Values
from heatlens.media.camera.placement import Matrix, matrix_of
from heatlens.media.camera.samples import LENS_TRACKS, CameraSamples, fields_of
from heatlens.media.files.json_record import JsonEntry, read_json, to_json

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
_TOP_LEVEL_NAMES = (
    _VERSION,
    "conventions",
    "name",
    "frames_per_second",
    "up_axis",
    _MODEL,
    _IMAGE,
    "samples",
)


def rows_of(camera: CameraSamples) -> list[Row]:
    """Return a row for each frame: its number, the known lens values and the matrix."""
    columns: dict[str, Sequence[object]] = {FRAME: camera.frames, **camera.lens_tracks}
    if camera.world_to_camera is not None:
        columns[PLACEMENT] = camera.world_to_camera
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def camera_of_rows(rows: Sequence[Row], **camera_fields: Any) -> CameraSamples:
    """Return the camera of rows; raise InputError if only some rows have a value."""
    for row in rows:
        if FRAME not in row:
            raise InputError(f"Row {rows.index(row) + 1} has no frame number.")
    columns: dict[str, object] = {name: _column(rows, name) for name in (*LENS_TRACKS, PLACEMENT)}
    frames = tuple(row[FRAME] for row in rows)
    return CameraSamples(frames=frames, **fields_of(columns), **camera_fields)


def _column(rows: Sequence[Row], name: str) -> tuple[object, ...] | None:
    """Return a value of each row; None if no row has it, InputError if only some do."""
    missing = [row for row in rows if name not in row]
    if len(missing) == len(rows):
        return None
    if missing:
        raise InputError(f"Frame {missing[0][FRAME]} has no {name}, but other frames do.")
    return tuple(row[name] for row in rows)


def json_text(camera: CameraSamples) -> str:
    """Return the JSON text, one frame in each line."""
    header = {
        _VERSION: CAMERA_VERSION,
        "conventions": _CONVENTIONS,
        "name": camera.name,
        "frames_per_second": to_json(camera.frames_per_second),
        "up_axis": camera.up_axis,
        **({} if camera.lens_model is None else {_MODEL: camera.lens_model}),
        **({} if camera.aperture_image is None else {_IMAGE: camera.aperture_image.path}),
    }
    lines = [f"  {json.dumps(name)}: {json.dumps(value)}," for name, value in header.items()]
    samples = (
        json.dumps({name: to_json(value) for name, value in row.items()}) for row in rows_of(camera)
    )
    body = ",\n".join(f"    {sample}" for sample in samples)
    return "\n".join(["{", *lines, '  "samples": [', body, "  ]", "}"]) + "\n"


def read_json_camera(path: Path) -> CameraSamples:
    """Read a camera; raise InputError that names the damaged entry."""
    document = read_json(path)
    document.check_version(_VERSION, CAMERA_VERSION, "camera")
    entries = document.members(_TOP_LEVEL_NAMES, ["samples"])
    fields: dict[str, object] = {
        "rows": [_parse_json_row(item) for item in entries["samples"].items()],
        "name": entries["name"].text() if "name" in entries else path.stem,
    }
    if "frames_per_second" in entries:
        fields["frames_per_second"] = entries["frames_per_second"].number()
    if "up_axis" in entries:
        fields["up_axis"] = entries["up_axis"].choice(("y", "z"))
    if _MODEL in entries:
        fields[_MODEL] = entries[_MODEL].convert(LensModel)
    if _IMAGE in entries:
        fields[_IMAGE] = entries[_IMAGE].convert(OpeningImage)
    return document.build(camera_of_rows, fields)


def _parse_json_row(item: JsonEntry) -> Row:
    """Return the values of a frame, by FRAME, the names of the tracks and PLACEMENT."""
    entries = item.members((FRAME, *LENS_TRACKS, PLACEMENT))
    row: dict[str, object] = {
        name: entries[name].number() for name in LENS_TRACKS if name in entries
    }
    if FRAME in entries:
        row[FRAME] = entries[FRAME].integer()
    if PLACEMENT in entries:
        matrix = [[value.number() for value in line.items()] for line in entries[PLACEMENT].items()]
        row[PLACEMENT] = entries[PLACEMENT].build(matrix_of, {"rows": matrix})
    return row


_RATE = "frames_per_second"
_UP_AXIS = "up_axis"
_TEXT_COLUMNS = (_UP_AXIS, _MODEL, _IMAGE)  # columns that hold no number
# Columns of the matrix row by row; it acts on column vectors in meters.
_CELLS = tuple(f"{PLACEMENT}_{row}{column}" for row in range(4) for column in range(4))
_COLUMNS = (FRAME, *LENS_TRACKS, _RATE, *_TEXT_COLUMNS, *_CELLS)


def csv_text(camera: CameraSamples) -> str:
    """Return the table as text, a row for each frame; infinity is written "inf"."""
    rows = [_cells_of_row(camera, row) for row in rows_of(camera)]
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
        text = read_file_bytes(path).decode("utf-8-sig")
        reader = csv.DictReader(io.StringIO(text, newline=""), strict=True)
        table = [(reader.line_num, row) for row in reader]
    except OSError as error:
        raise unreadable_error(path, error) from error
    except (ValueError, csv.Error) as error:
        raise damaged_table_error(path, error) from error
    _check_columns(path, reader.fieldnames or ())
    if not table:
        raise InputError(f"{path} has no rows: a camera needs at least one frame.")
    rows = [_parse_csv_row(path, line, cells) for line, cells in table]
    first_row_fields = {name: rows[0][name] for name in (_RATE, *_TEXT_COLUMNS) if name in rows[0]}
    if _MODEL in first_row_fields:
        first_row_fields[_MODEL] = _parse_lens_model(path, first_row_fields[_MODEL])
    if _IMAGE in first_row_fields:
        first_row_fields[_IMAGE] = OpeningImage(first_row_fields[_IMAGE])
    try:
        return camera_of_rows(rows, name=path.stem, **first_row_fields)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def damaged_table_error(path: Path, error: Exception) -> InputError:
    """Return the error for a table that is no text, or whose cells do not fit."""
    reason = "it is not text in UTF-8" if isinstance(error, UnicodeError) else error
    return InputError(f"{path} is damaged: {reason}. Export it again.")


def _cells_of_row(camera: CameraSamples, row: Row) -> dict[str, object]:
    """Return the cells of a frame's line in the table by the names of their columns."""
    cells = {name: value for name, value in row.items() if name != PLACEMENT}
    cells |= {_RATE: camera.frames_per_second, _UP_AXIS: camera.up_axis}
    if camera.lens_model is not None:
        cells[_MODEL] = camera.lens_model
    if camera.aperture_image is not None:
        cells[_IMAGE] = camera.aperture_image.path
    if PLACEMENT in row:
        numbers = (number for line in row[PLACEMENT] for number in line)
        cells |= dict(zip(_CELLS, numbers, strict=True))
    return cells


def _check_columns(path: Path, names: Sequence[str]) -> None:
    """Raise InputError for a column that is unknown, with a similar name, or occurs twice."""
    for name in names:
        if name not in _COLUMNS:
            similar_names = get_close_matches(str(name), _COLUMNS, 1)
            hint = (
                f"did you mean {similar_names[0]!r}?"
                if similar_names
                else f"known are {', '.join(_COLUMNS[:9])}"
            )
            raise InputError(f"{path}: unknown column {name!r}; {hint}")
        if list(names).count(name) > 1:
            raise InputError(f"{path}: the column {name!r} occurs twice.")


def _parse_csv_row(path: Path, line: int, cells: Mapping[str | None, str]) -> Values:
    """Return the values of a line by the names of their columns, without the empty cells."""
    if None in cells or None in cells.values():
        raise InputError(f"{path}: line {line} has more or fewer cells than there are columns.")
    texts = {str(name): text.strip() for name, text in cells.items() if text.strip()}
    row: Values = {
        name: text if name in _TEXT_COLUMNS else _parse_number(path, line, name, text)
        for name, text in texts.items()
    }
    if FRAME in row:
        row[FRAME] = _to_whole_frame(path, line, row[FRAME])
    if any(name in row for name in _CELLS):
        row[PLACEMENT] = _matrix_of_cells(path, line, row)
    return row


def _parse_lens_model(path: Path, text: str) -> LensModel:
    """Return the lens model called `text`; raise InputError for another text."""
    if text not in list(LensModel):
        names = " or ".join(LensModel)
        raise InputError(f"{path}: {_MODEL} should be {names}, got {text!r}.")
    return LensModel(text)


def _parse_number(path: Path, line: int, name: str, text: str) -> float:
    """Return the number in a cell, which may be infinite; raise InputError for another text."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if math.isnan(number):
        raise InputError(f"{path}: line {line}: {name} should be a number, got {text!r}.")
    return number


def _to_whole_frame(path: Path, line: int, frame: float) -> int:
    """Return the frame as an integer; raise InputError for a fraction."""
    if not frame.is_integer():
        raise InputError(f"{path}: line {line}: a frame should be a whole number, got {frame:g}.")
    return int(frame)


def _matrix_of_cells(path: Path, line: int, row: Row) -> Matrix:
    """Return the placement in the 16 cells of a row. Raises InputError if one is empty."""
    missing = [name for name in _CELLS if name not in row]
    if missing:
        raise InputError(f"{path}: line {line}: the position of the camera lacks {missing[0]}.")
    cells = [row[name] for name in _CELLS]
    return matrix_of([cells[index : index + 4] for index in range(0, 16, 4)])
