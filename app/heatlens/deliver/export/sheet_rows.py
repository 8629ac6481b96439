"""Make the rows of a pull sheet: the focus at each key as text, for the page and the table."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.focus.coc import far_limit_m, near_limit_m
from heatlens.core.model.lens.lens import measured_text
from heatlens.core.model.shot.pull import bake_live_focus
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.timecode import Timecode

_CHECKED_FRACTIONS = (
    0.0,
    0.25,
    0.5,
    0.75,
    1.0,
)  # points between two rows at which a held focus is checked
_STILL_DIOPTRES = 1e-6  # dioptres
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
    """One mark, in words: its distance in meters and in feet, or the range if it moves."""

    name: str
    distance: str
    feet: str


def sheet_frames(shot: Shot, frames: FrameRange) -> list[float]:
    """Return the frames that have a row: the keys of the focus, and both ends of `frames`.

    A focus that follows a mark has no keys; it has rows at the keys that would describe it.
    """
    key_frames = [key.frame for key in bake_live_focus(shot).curves.focus_distance_m.keys]
    inside_frames = [frame for frame in key_frames if frames.first <= frame <= frames.last]
    return sorted({float(frames.first), *inside_frames, float(frames.last)})


def sheet_row(
    shot: Shot,
    frame: float,
    first: int,
    marks: Distances,
    timecode: Timecode | None = None,
    next_frame: float | None = None,
) -> SheetRow:
    """Return the row of a frame of a shot whose first frame is `first`.

    `marks` has the distances of marks at the frame in meters, `timecode` is that of the frame, and
    `next_frame` is the frame of the next row; None for the last row.
    """
    lens = shot.lens_at(frame)
    return SheetRow(
        frame=f"{frame:.10g}",
        timecode="" if timecode is None else str(timecode),
        seconds=f"{(frame - first) / shot.frames_per_second:.2f}",
        mark=_name_of_mark_at(lens.focus_distance_m, marks),
        focus=measured_text(lens, lens.focus_distance_m),
        feet=measured_text(lens, lens.focus_distance_m, "ft"),
        near=measured_text(lens, near_limit_m(lens)),
        far=measured_text(lens, far_limit_m(lens)),
        f_stop=f"f/{lens.f_stop:.3g}",
        to_next="" if next_frame is None else _text_to_next_row(shot, frame, next_frame),
        near_feet=measured_text(lens, near_limit_m(lens), "ft"),
        far_feet=measured_text(lens, far_limit_m(lens), "ft"),
    )


def _text_to_next_row(shot: Shot, frame: float, next_frame: float) -> str:
    """Return "18 frames", or "hold 18 frames" where the focus does not move between two rows."""
    times = [frame + fraction * (next_frame - frame) for fraction in _CHECKED_FRACTIONS]
    focus_m = {shot.lens_at(time).focus_distance_m for time in times}
    nearest, farthest = min(focus_m), max(focus_m)
    hold_text = (
        "hold " if nearest == farthest or 1.0 / nearest - 1.0 / farthest < _STILL_DIOPTRES else ""
    )
    return (
        f"{hold_text}{next_frame - frame:.10g} {'frame' if next_frame - frame == 1.0 else 'frames'}"
    )


def mark_rows(shot: Shot, distances_of_rows: Sequence[Distances]) -> list[MarkRow]:
    """Return a row for each mark of the shot that has a distance in any row of the sheet."""
    rows = []
    for mark in shot.marks:
        distances_m = [
            distance_m
            for marks in distances_of_rows
            for name, distance_m in marks
            if name == mark.name
        ]
        if distances_m:
            ends = min(distances_m), max(distances_m)
            rows.append(
                MarkRow(mark.name, _range_text(shot, *ends, "m"), _range_text(shot, *ends, "ft"))
            )
    return rows


def _range_text(shot: Shot, near_m: float, far_m: float, unit: str) -> str:
    """Return a range of distances as text; one distance if both ends read the same."""
    near, far = (measured_text(shot.lens, it, unit) for it in (near_m, far_m))
    return near if near == far else f"{near} to {far}"


def _name_of_mark_at(distance_m: float, marks: Distances) -> str:
    """Return the name of the closest mark at a distance; "" if there is none."""
    near_marks = [
        (abs(1.0 / mark_distance_m - 1.0 / distance_m), name)
        for name, mark_distance_m in marks
        if abs(1.0 / mark_distance_m - 1.0 / distance_m)
        <= _NEAR_SHARE / min(mark_distance_m, distance_m)
    ]
    return min(near_marks)[1] if near_marks else ""


def sheet_csv(rows: Sequence[SheetRow], shots: Sequence[str] = ()) -> str:
    """Return the rows as CSV with a head line; `shots` names the shot of each row of a reel."""
    names = list(SheetRow.__dataclass_fields__)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    shot_cells = [[shot] for shot in shots] or [[]] * len(rows)
    writer.writerow([*(["shot"] if shots else []), *names])
    for shot, row in zip(shot_cells, rows, strict=True):
        writer.writerow([*shot, *(getattr(row, name) for name in names)])
    return text.getvalue()
