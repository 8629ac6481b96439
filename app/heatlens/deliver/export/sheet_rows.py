"""Make the rows of a pull sheet: the focus at each key as text, for the page and the table."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.coc import far_limit_m, near_limit_m
from heatlens.core.model.lens.lens import measured_text
from heatlens.core.model.shot.pull import baked
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.timecode import Timecode

_BETWEEN = (0.0, 0.25, 0.5, 0.75, 1.0)  # points between two rows at which a held focus is checked
_STILL = 1e-6  # dioptres
_NEAR_SHARE = 0.01  # a key within this share of a mark's distance belongs to the mark
Distances = Sequence[tuple[str, float]]  # names and distances of marks


@dataclass(frozen=True)
class SheetRow:
    """One key of the focus, in words.

    frame     its number
    timecode  of the frame; "" if neither shot nor plate has one
    seconds   since the first frame
    mark      the mark in focus; "" if there is none
    focus     distance, and `feet` the same in feet
    near, far limits of the sharp range; `near_feet` and `far_feet` the same in feet
    f_stop    as on the ring
    to_next   frames to the next row, and whether the focus is held; "" in the last row
    """

    frame: str
    timecode: str
    seconds: str
    mark: str
    focus: str
    feet: str
    near: str
    far: str
    f_stop: str
    to_next: str
    near_feet: str
    far_feet: str


@dataclass(frozen=True)
class MarkRow:
    """One mark, in words: its distance in metres and in feet, or the range if it moves."""

    name: str
    distance: str
    feet: str


def sheet_frames(shot: Shot, frames: FrameRange) -> list[float]:
    """Return the frames that have a row: the keys of the focus, and both ends of `frames`.

    A focus that follows has those at which keys would describe it.
    """
    keyed = [key.frame for key in baked(shot).curves.focus_distance_m.keys]
    inside = [frame for frame in keyed if frames.first <= frame <= frames.last]
    return sorted({float(frames.first), *inside, float(frames.last)})


def sheet_row(
    shot: Shot,
    frame: float,
    first: int,
    marks: Distances,
    timecode: Timecode | None = None,
    after: float | None = None,
) -> SheetRow:
    """Return the row of a frame of a shot whose first frame is `first`.

    `marks` has the distances of marks at the frame in metres, `timecode` is that of the frame, and
    `after` is the frame of the next row.
    """
    lens = shot.lens_at(frame)
    return SheetRow(
        frame=f"{frame:.10g}",
        timecode="" if timecode is None else str(timecode),
        seconds=f"{(frame - first) / shot.frames_per_second:.2f}",
        mark=_mark_at(lens.focus_distance_m, marks),
        focus=measured_text(lens, lens.focus_distance_m),
        feet=measured_text(lens, lens.focus_distance_m, "ft"),
        near=measured_text(lens, near_limit_m(lens)),
        far=measured_text(lens, far_limit_m(lens)),
        f_stop=f"f/{lens.f_stop:.3g}",
        to_next="" if after is None else _to_next(shot, frame, after),
        near_feet=measured_text(lens, near_limit_m(lens), "ft"),
        far_feet=measured_text(lens, far_limit_m(lens), "ft"),
    )


def _to_next(shot: Shot, frame: float, after: float) -> str:
    """Return "18 frames", or "hold 18 frames" where the focus does not move between two rows."""
    times = [frame + part * (after - frame) for part in _BETWEEN]
    focus_m = {shot.lens_at(time).focus_distance_m for time in times}
    nearest, farthest = min(focus_m), max(focus_m)
    held = "hold " if nearest == farthest or 1.0 / nearest - 1.0 / farthest < _STILL else ""
    return f"{held}{after - frame:.10g} {'frame' if after - frame == 1.0 else 'frames'}"


def mark_rows(shot: Shot, seen: Sequence[Distances]) -> list[MarkRow]:
    """Return a row for each mark of the shot; `seen` are the distances of marks in each row."""
    rows = []
    for mark in shot.marks:
        distances_m = [far_m for marks in seen for name, far_m in marks if name == mark.name]
        if distances_m:
            ends = min(distances_m), max(distances_m)
            rows.append(MarkRow(mark.name, _span(shot, *ends, "m"), _span(shot, *ends, "ft")))
    return rows


def _span(shot: Shot, near_m: float, far_m: float, unit: str) -> str:
    near, far = (measured_text(shot.lens, it, unit) for it in (near_m, far_m))
    return near if near == far else f"{near} to {far}"


def _mark_at(distance_m: float, marks: Distances) -> str:
    """Return the name of the closest mark at a distance; "" if there is none."""
    near = [
        (abs(1.0 / far_m - 1.0 / distance_m), name)
        for name, far_m in marks
        if abs(1.0 / far_m - 1.0 / distance_m) <= _NEAR_SHARE / min(far_m, distance_m)
    ]
    return min(near)[1] if near else ""


def sheet_csv(rows: Sequence[SheetRow], shots: Sequence[str] = ()) -> str:
    """Return the rows as CSV with a head line; `shots` names the shot of each row of a reel."""
    names = list(SheetRow.__dataclass_fields__)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    first = [[shot] for shot in shots] or [[]] * len(rows)
    writer.writerow([*(["shot"] if shots else []), *names])
    for shot, row in zip(first, rows, strict=True):
        writer.writerow([*shot, *(getattr(row, name) for name in names)])
    return text.getvalue()
