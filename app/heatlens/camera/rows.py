"""Convert a camera to rows for each frame, which JSON and CSV files hold, and back."""

from collections.abc import Mapping, Sequence
from typing import Any

from heatlens.base.errors import InputError
from heatlens.camera.samples import LENS_TRACKS, CameraSamples, fields_of

FRAME = "frame"
PLACEMENT = "world_to_camera"

Row = Mapping[str, Any]


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
