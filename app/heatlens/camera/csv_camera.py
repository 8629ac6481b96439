"""Read and write a camera as a table: a row for each frame, with units in the column names."""

import csv
import io
import math
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path

from heatlens.base.errors import InputError
from heatlens.base.paths import file_bytes, unreadable
from heatlens.camera.placement import Matrix, matrix_of
from heatlens.camera.rows import FRAME, PLACEMENT, Row, camera_of_rows, rows_of
from heatlens.camera.samples import LENS_TRACKS, CameraSamples
from heatlens.model.lens.lens_model import LensModel
from heatlens.model.lens.opening_image import OpeningImage
from heatlens.model.option import Values

_RATE = "frames_per_second"
_UP = "up_axis"
_MODEL = "lens_model"
_IMAGE = "aperture_image"
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
    rows = [_row(path, line, cells) for line, cells in table]
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


def _row(path: Path, line: int, cells: Mapping[str | None, str]) -> Values:
    """Return the values of a line by the names of their columns, without the empty cells."""
    if None in cells or None in cells.values():
        raise InputError(f"{path}: line {line} has more or fewer cells than there are columns.")
    told = {str(name): text.strip() for name, text in cells.items() if text.strip()}
    row: Values = {
        name: text if name in _WORDS else _number(path, line, name, text)
        for name, text in told.items()
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
