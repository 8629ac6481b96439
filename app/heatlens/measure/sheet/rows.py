"""Make the rows of a pull sheet: the focus at each key as text, for the page and the table."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass

from heatlens.model.coc import far_limit_m, near_limit_m
from heatlens.model.frames import FrameRange
from heatlens.model.measured_distance import measured_text
from heatlens.model.shot import Shot
from heatlens.model.timecode import Timecode

_NEAR_SHARE = 0.01  # a key within this part of a mark's distance belongs to the mark
Distances = Sequence[tuple[str, float]]  # names and distances of marks


@dataclass(frozen=True)
class SheetRow:
    """One key of the focus, in words.

    frame     its number
    timecode  of the frame; "" where neither shot nor plate tells one
    seconds   since the first frame
    mark      what is in focus there; "" where no mark is
    focus     distance, and `feet` the same in feet
    near, far limits of what is sharp
    f_stop    as on the ring
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


def sheet_frames(shot: Shot, frames: FrameRange) -> list[float]:
    """Return the frames that have a row: the keys of the focus, and both ends of `frames`."""
    keyed = [key.frame for key in shot.curves.focus_distance_m.keys]
    inside = [frame for frame in keyed if frames.first <= frame <= frames.last]
    return sorted({float(frames.first), *inside, float(frames.last)})


def sheet_row(
    shot: Shot, frame: float, first: int, marks: Distances, timecode: Timecode | None = None
) -> SheetRow:
    """Return the row of a frame of a shot whose first frame is `first`.

    `marks` tells how far marks are at the frame, in metres, and `timecode` is that of the frame.
    """
    lens = shot.lens_at(frame)
    return SheetRow(
        frame=f"{frame:g}",
        timecode="" if timecode is None else str(timecode),
        seconds=f"{(frame - first) / shot.frames_per_second:.2f}",
        mark=_mark_at(lens.focus_distance_m, marks),
        focus=measured_text(lens, lens.focus_distance_m),
        feet=measured_text(lens, lens.focus_distance_m, "ft"),
        near=measured_text(lens, near_limit_m(lens)),
        far=measured_text(lens, far_limit_m(lens)),
        f_stop=f"f/{lens.f_stop:.3g}",
    )


def _mark_at(distance_m: float, marks: Distances) -> str:
    """Return the name of the closest mark at a distance; "" if there is none."""
    near = [
        (abs(1.0 / far_m - 1.0 / distance_m), name)
        for name, far_m in marks
        if abs(1.0 / far_m - 1.0 / distance_m) <= _NEAR_SHARE / min(far_m, distance_m)
    ]
    return min(near)[1] if near else ""


def sheet_csv(rows: Sequence[SheetRow]) -> str:
    """Return the rows as CSV with a head line."""
    names = list(SheetRow.__dataclass_fields__)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    writer.writerows([getattr(row, name) for name in names] for row in rows)
    return text.getvalue()
