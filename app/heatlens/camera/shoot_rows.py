"""Split the table of a shoot into rows, and report cells that cannot be read."""

import csv
import io
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from heatlens.base.errors import InputError
from heatlens.plate.header.shoot_names import ShootLens

Row = Mapping[str, str]

_WITH_POINT = re.compile(r"\s*[0-9]+\.[0-9]+\s*")
_WITH_COMMA = re.compile(r"\s*[0-9]+,([0-9]+)\s*")
_THOUSAND = 3  # digits after a comma that may separate thousands
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
    too_wide     a sentence on the first row with more cells than columns; "" without one
    """

    columns: tuple[str, ...]
    rows: tuple[Row, ...]
    row_numbers: tuple[int, ...]
    too_wide: str


def table_of(text: str) -> ShootTable:
    """Return the rows of a table whose cells are separated by commas, semicolons or tabs.

    Decimal commas become points where the table has no points. Raises csv.Error for damaged
    text.
    """
    head = text.split("\n", 1)[0]
    between = max("\t;,", key=head.count)
    reader = csv.DictReader(io.StringIO(text, newline=""), delimiter=between, skipinitialspace=True)
    rows: list[Row] = []
    numbers: list[int] = []
    too_wide = ""
    for row in reader:
        too_wide = too_wide or _too_wide(row, reader.line_num, between)
        rows.append({str(name): str(cell or "") for name, cell in row.items() if name})
        numbers.append(reader.line_num)
    if _has_decimal_commas(rows, between):
        rows = [{name: _pointed(cell) for name, cell in row.items()} for row in rows]
    return ShootTable(tuple(reader.fieldnames or ()), tuple(rows), tuple(numbers), too_wide)


def unreadable_notes(path: Path, table: ShootTable, lenses: Sequence[ShootLens]) -> list[str]:
    """Return a sentence for each value of the lens that cannot be read in some rows.

    Raises InputError if most cells of a column that hold anything cannot be read.
    """
    notes = []
    for field, expected in _EXPECTED.items():
        bad = [index for index, lens in enumerate(lenses) if field in lens.unreadable]
        if not bad:
            continue
        column = lenses[bad[0]].unreadable[field]
        cell = table.rows[bad[0]][column].strip()
        count = len(bad) + sum(getattr(lens, field) is not None for lens in lenses)
        where = f"row {table.row_numbers[bad[0]]} holds {cell!r}, which is not {expected}"
        if 2 * len(bad) > count:
            raise InputError(
                f"{path}: the column {column!r} cannot be read in {len(bad)} of {count} rows: "
                f"{where}."
            )
        notes.append(
            f"The column {column!r} cannot be read in {len(bad)} of {count} rows, which keep the "
            f"neighbouring row's value: {where}."
        )
    return notes


def conflict_notes(table: ShootTable, lenses: Sequence[ShootLens]) -> list[str]:
    """Return a sentence for each value on which two columns disagree in some row."""
    notes = []
    for field in _EXPECTED:
        rows = [index for index, lens in enumerate(lenses) if field in lens.conflicts]
        if rows:
            lens, row = lenses[rows[0]], table.rows[rows[0]]
            first, other = lens.sources[field], lens.conflicts[field]
            notes.append(
                f"The columns {first!r} and {other!r} disagree in {len(rows)} of {len(lenses)} "
                f"rows, and {first!r} counts: row {table.row_numbers[rows[0]]} holds "
                f"{row[first].strip()!r} and {row[other].strip()!r}."
            )
    return notes


def _too_wide(row: Mapping[str | None, object], number: int, between: str) -> str:
    """Return a sentence if cells lie beyond the last column, as after unquoted decimal commas."""
    extra = row.get(None)
    if not isinstance(extra, list) or not any(str(cell).strip() for cell in extra):
        return ""
    hint = " Numbers with a decimal comma need quotes." if between == "," else ""
    return f"row {number} has more cells than the table has columns.{hint}"


def _has_decimal_commas(rows: Sequence[Row], between: str) -> bool:
    """Return True if a comma marks decimals even before three digits, as in 4,812.

    In a table with a point in any number they do not, because commas may separate thousands.
    Otherwise, semicolons between the cells show it, and so does a comma not before three digits.
    """
    cells = [cell for row in rows for cell in row.values()]
    if any(_WITH_POINT.fullmatch(cell) for cell in cells):
        return False
    after = [match[1] for cell in cells if (match := _WITH_COMMA.fullmatch(cell))]
    return between == ";" or any(len(digits) != _THOUSAND for digits in after)


def _pointed(cell: str) -> str:
    """Return the cell with points for decimal commas."""
    return re.sub(r"(?<=[0-9]),(?=[0-9])", ".", cell)
