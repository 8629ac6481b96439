"""Read the lens metadata table of a shoot: focus, iris and focal length of a lens at each frame.

The tables of ARRI Meta Extract, RED and Sony are supported, and any others with similar column
names; see `heatlens.media.plate.header.shoot_names`. A table is split into rows, and cells that
cannot be read are reported.
"""

import csv
import io
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import read_file_bytes, unreadable_error
from heatlens.core.model.curves.frames import FRAMES_PER_SECOND
from heatlens.core.model.option import Values
from heatlens.core.model.timecode import Timecode, try_parse_timecode
from heatlens.media.camera.rows import damaged_table_error
from heatlens.media.camera.samples import CameraSamples
from heatlens.media.plate.header.shoot_names import (
    ShootLens,
    read_shoot_lens,
    unknown_columns_sentence,
)

Row = Mapping[str, str]

_WITH_POINT = re.compile(r"\s*[0-9]+\.[0-9]+\s*")
_WITH_COMMA = re.compile(r"\s*[0-9]+,([0-9]+)\s*")
_THOUSANDS_DIGITS = 3  # digits after a comma that may separate thousands
_EXPECTED = {
    "focus_distance_m": """a distance such as 2.24, 190cm, 6'3" or inf""",
    "focal_length_mm": "a focal length such as 50 or 50mm",
    "f_stop": "an f-stop such as 2.8",
    "t_stop": "a T-stop such as 2.8 or T2.8",
    "squeeze": "a squeeze from 1 to 2",
}


@dataclass(frozen=True)
class ShootTable:
    """The cells of a table.

    columns      names in the order of the file
    rows         cells by the name of their column
    row_numbers  the line of the file in which each row ends; the columns are in line 1
    extra_cells_note  a sentence on the first row with more cells than columns; "" without one
    """

    columns: tuple[str, ...]
    rows: tuple[Row, ...]
    row_numbers: tuple[int, ...]
    extra_cells_note: str


def parse_table(text: str) -> ShootTable:
    """Return the rows of a table whose cells are separated by commas, semicolons or tabs.

    Decimal commas become points where the table has no points. Raises csv.Error for damaged
    text.
    """
    column_line = text.split("\n", 1)[0]
    separator = max("\t;,", key=column_line.count)
    reader = csv.DictReader(
        io.StringIO(text, newline=""), delimiter=separator, skipinitialspace=True
    )
    rows: list[Row] = []
    numbers: list[int] = []
    extra_cells_note = ""
    for row in reader:
        extra_cells_note = extra_cells_note or _extra_cells_note(row, reader.line_num, separator)
        rows.append({str(name): str(cell or "") for name, cell in row.items() if name})
        numbers.append(reader.line_num)
    if _has_decimal_commas(rows, separator):
        rows = [{name: _replace_decimal_commas(cell) for name, cell in row.items()} for row in rows]
    return ShootTable(tuple(reader.fieldnames or ()), tuple(rows), tuple(numbers), extra_cells_note)


def unreadable_notes(path: Path, table: ShootTable, lenses: Sequence[ShootLens]) -> list[str]:
    """Return a sentence for each value of the lens that cannot be read in some of the rows.

    Raises InputError if most cells of a column that hold anything cannot be read.
    """
    notes = []
    for field, expected in _EXPECTED.items():
        bad_rows = [index for index, lens in enumerate(lenses) if field in lens.unreadable]
        if not bad_rows:
            continue
        column = lenses[bad_rows[0]].unreadable[field]
        cell = table.rows[bad_rows[0]][column].strip()
        count = len(bad_rows) + sum(getattr(lens, field) is not None for lens in lenses)
        example = f"row {table.row_numbers[bad_rows[0]]} holds {cell!r}, which is not {expected}"
        if 2 * len(bad_rows) > count:
            raise InputError(
                f"{path}: the column {column!r} cannot be read in {len(bad_rows)} of {count} rows: "
                f"{example}."
            )
        notes.append(
            f"The column {column!r} cannot be read in {len(bad_rows)} of {count} rows, which "
            "keep the "
            f"neighbouring row's value: {example}."
        )
    return notes


def conflict_notes(table: ShootTable, lenses: Sequence[ShootLens]) -> list[str]:
    """Return a sentence for each value on which two columns disagree in some row."""
    notes = []
    for field in _EXPECTED:
        rows = [index for index, lens in enumerate(lenses) if field in lens.conflicts]
        if rows:
            lens, row = lenses[rows[0]], table.rows[rows[0]]
            used_column, ignored_column = lens.sources[field], lens.conflicts[field]
            notes.append(
                f"The columns {used_column!r} and {ignored_column!r} disagree in {len(rows)} of "
                f"{len(lenses)} "
                f"rows, and {used_column!r} counts: row {table.row_numbers[rows[0]]} holds "
                f"{row[used_column].strip()!r} and {row[ignored_column].strip()!r}."
            )
    return notes


def _extra_cells_note(row: Mapping[str | None, object], number: int, separator: str) -> str:
    """Return a sentence if a row has cells beyond the last column; else "".

    Unquoted decimal commas can be the cause.
    """
    extra_cells = row.get(None)
    if not isinstance(extra_cells, list) or not any(str(cell).strip() for cell in extra_cells):
        return ""
    hint = " Numbers with a decimal comma need quotes." if separator == "," else ""
    return f"row {number} has more cells than the table has columns.{hint}"


def _has_decimal_commas(rows: Sequence[Row], separator: str) -> bool:
    """Return True if a comma before three digits, as in 4,812, marks decimals too.

    A number with a decimal point anywhere in the table means that commas may separate thousands.
    Without one, semicolons between the cells, or a comma before other than three digits, show that
    the table has decimal commas.
    """
    cells = [cell for row in rows for cell in row.values()]
    if any(_WITH_POINT.fullmatch(cell) for cell in cells):
        return False
    decimals = [match[1] for cell in cells if (match := _WITH_COMMA.fullmatch(cell))]
    return separator == ";" or any(len(digits) != _THOUSANDS_DIGITS for digits in decimals)


def _replace_decimal_commas(cell: str) -> str:
    """Return the cell with points for decimal commas."""
    return re.sub(r"(?<=[0-9]),(?=[0-9])", ".", cell)


_FRAMES = ("frame", "frameno", "frame number", "index")
_TIMECODES = ("master tc", "timecode", "time code", "tc", "lens tc", "timecode in")
_RATES = ("project fps", "fps", "sensor fps", "frames_per_second")
_RED_COLUMNS = {"FrameNo", "Acceleration X"}  # RED gives distances in mm, without stating the unit
_HEATLENS_COLUMNS = {"focus_distance_m", "focal_length_mm", "nominal_f_stop", "f_stop", "up_axis"}
_LENS_FIELDS = {"focus_distance_m", "focal_length_mm", "t_stop", "f_stop"}
_TRACK_NAMES = ("focal_length_mm", "f_stop", "focus_distance_m", "squeeze")
_T_AS_F = (
    "The iris is in T-stops, which are taken as f-stops: the true f-stop is a little wider, by "
    "the light that the glass absorbs."
)
_METRES = (
    "The focus has no unit{0} and is taken as metres; for another, give --table-unit focus=mm, "
    "cm, ft or in."
)
_EXPECTED_TRACKS = ("focus_distance_m", "f_stop", "focal_length_mm")


def is_shoot_table(names: Sequence[str]) -> bool:
    """Return whether the columns are those of a shoot: at least two of them are lens values."""
    # With "1" in each cell, every column that is understood becomes a source of a lens value.
    example = read_shoot_lens({name: "1" for name in names if name})
    return len(_LENS_FIELDS & set(example.sources)) > 1


def table_columns(path: Path) -> list[str]:
    """Return the names of the columns of a table, or [] if heatlens itself wrote the table."""
    names = _read_table(path).columns
    return [] if _HEATLENS_COLUMNS & set(names) else list(names)


def read_shoot_table(
    path: Path, first_frame: int | None = None, focus_unit_m: float | None = None
) -> CameraSamples:
    """Read the lens at each row; the first row is at `first_frame`, or as numbered in the table.

    Without `first_frame` the timecodes of the rows are kept, to be matched with those of a shot.
    `focus_unit_m` is the unit of focus distances that have none of their own, where it is known. A
    missing value is taken from the row before; so are a few unreadable ones, with a note. Raises
    InputError if the file cannot be read, has no rows, most values of a column cannot be read, or
    the frames are not in order.
    """
    table = _read_table(path)
    rows = table.rows
    if not rows:
        raise InputError(f"{path} has no rows: a camera needs at least one frame.")
    if table.extra_cells_note:
        raise InputError(f"{path}: {table.extra_cells_note}")
    unit_m = 1e-3 if _RED_COLUMNS <= set(rows[0]) else None
    lenses = [read_shoot_lens(row, unit_m, focus_unit_m) for row in rows]
    tracks = _tracks(lenses)
    notes = _notes(path, table, lenses, tracks)
    if all(track is None for track in tracks.values()):
        raise InputError(
            f"{path}: no row has a value of the lens: columns such as focus, iris and focal length "
            f"are needed. {_unknown_columns_note(table)}".strip()
        )
    try:
        return CameraSamples(
            name=path.name.split(".")[0],
            frames=_frames(rows, first_frame),
            **tracks,
            frames_per_second=_frame_rate(rows[0]),
            timecodes=_timecodes(rows) if first_frame is None else None,
            has_focus_unit=any(lens.has_unit and lens.focus_distance_m for lens in lenses),
            notes=notes,
        )
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _read_table(path: Path) -> ShootTable:
    """Read a table whose cells are separated by commas, semicolons or tabs. Raises InputError."""
    try:
        return parse_table(read_file_bytes(path).decode("utf-8-sig"))
    except OSError as error:
        raise unreadable_error(path, error) from error
    except (ValueError, csv.Error) as error:
        raise damaged_table_error(path, error) from error


def _tracks(lenses: Sequence[ShootLens]) -> Values:
    """Return the track of each field in _TRACK_NAMES, or None if no row has a value.

    T-stops stand in for f-stops if there are none.
    """
    tracks = {name: _filled_track(name, lenses) for name in _TRACK_NAMES}
    return tracks | {"f_stop": tracks["f_stop"] or _filled_track("t_stop", lenses)}


def _filled_track(name: str, lenses: Sequence[ShootLens]) -> tuple[float, ...] | None:
    """Return a value for each row, or None if no row has one.

    A missing value is that of the row before; in front of the first value, it is the first value.
    """
    values = [getattr(lens, name) for lens in lenses]
    first = next((value for value in values if value is not None), None)
    if first is None:
        return None
    filled: list[float] = []
    for value in values:
        filled.append(value if value is not None else filled[-1] if filled else first)
    return tuple(filled)


def _notes(
    path: Path, table: ShootTable, lenses: Sequence[ShootLens], tracks: Values
) -> tuple[str, ...]:
    """Return notes on the values, and on columns that may hold missing ones."""
    is_t_stop = tracks["f_stop"] is not None and _filled_track("f_stop", lenses) is None
    unknown = (
        _unknown_columns_note(table)
        if any(tracks[name] is None for name in _EXPECTED_TRACKS)
        else ""
    )
    return (
        *unreadable_notes(path, table, lenses),
        *conflict_notes(table, lenses),
        *_unit_notes(lenses),
        *filter(None, (_T_AS_F if is_t_stop else "", unknown)),
    )


def _unit_notes(lenses: Sequence[ShootLens]) -> list[str]:
    """Return a sentence if the focus of some rows has no known unit."""
    count = sum(not lens.has_unit for lens in lenses)
    if not count:
        return []
    focus_count = sum(lens.focus_distance_m is not None for lens in lenses)
    if count == focus_count:
        return [_METRES.format("")]
    return [_METRES.format(f" in {count} of {focus_count} rows")]


def _unknown_columns_note(table: ShootTable) -> str:
    """Return a sentence on the columns that are not understood; "" where all are."""
    known_columns = {*_FRAMES, *_TIMECODES, *_RATES}
    return unknown_columns_sentence(
        name for name in table.columns if name.strip().lower() not in known_columns
    )


def _frames(rows: Sequence[Row], first_frame: int | None) -> tuple[int, ...]:
    """Return the frame of each row: from the column of frames, else counted from 0.

    With `first_frame` the first row is at that frame, and the others keep their distance to it.
    """
    column = _find_column(rows[0], _FRAMES)
    if column is None:
        first = 0 if first_frame is None else first_frame
        return tuple(range(first, first + len(rows)))
    try:
        frames = [int(row[column].strip()) for row in rows]
    except ValueError:
        raise InputError(f"The column {column!r} should hold whole numbers.") from None
    shift = 0 if first_frame is None else first_frame - frames[0]
    return tuple(frame + shift for frame in frames)


def _timecodes(rows: Sequence[Row]) -> tuple[Timecode, ...] | None:
    """Return the timecode of each row; None if any row has none."""
    column = _find_column(rows[0], _TIMECODES)
    if column is None:
        return None
    timecodes = [try_parse_timecode(row[column]) for row in rows]
    valid_timecodes = tuple(timecode for timecode in timecodes if timecode is not None)
    return valid_timecodes if len(valid_timecodes) == len(rows) else None


def _frame_rate(row: Row) -> float:
    """Return the frames per second in a row, else the usual rate."""
    column = _find_column(row, _RATES)
    try:
        rate = float(row[column]) if column is not None else 0.0
    except ValueError:
        rate = 0.0
    return rate if 0 < rate <= 1000 else FRAMES_PER_SECOND


def _find_column(row: Row, accepted_names: Sequence[str]) -> str | None:
    """Return the column that has one of these names, ignoring case; None if none has."""
    by_lower_case = {name.strip().lower(): name for name in row}
    return next((by_lower_case[name] for name in accepted_names if name in by_lower_case), None)
