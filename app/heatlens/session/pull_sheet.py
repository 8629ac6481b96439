"""The pull sheet: the focus pull of a shot on one page, for the first assistant on the set.

HTML that needs nothing beside it, and the same rows as CSV.
"""

import csv
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from heatlens.files.atomic_file import write_whole
from heatlens.measure.extras import import_extra
from heatlens.model.coc import far_limit_m, near_limit_m
from heatlens.model.frames import FrameRange
from heatlens.model.shot import Shot
from heatlens.model.units import format_distance
from heatlens.plate.timecode import Timecode

_TEMPLATE = "pull_sheet.html.jinja"
_NEAR_SHARE = 0.01  # of a distance, within which a mark is meant by a key
Distances = Sequence[tuple[str, float]]  # names of marks, and how far they are


@dataclass(frozen=True)
class SheetRow:
    """One key of the focus, in words.

    frame     its number
    timecode  of the frame; "" where the plate tells none
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


def sheet_rows(
    shot: Shot,
    frames: FrameRange,
    marks_at: Callable[[float], Distances],
    timecode: tuple[Timecode, int] | None = None,
) -> list[SheetRow]:
    """Return a row for each key of the focus, and for both ends of `frames`.

    `marks_at` tells how far marks are at a frame, in metres. `timecode` is that of a frame, and
    the frame.
    """
    keyed = [key.frame for key in shot.curves.focus_distance_m.keys]
    inside = [frame for frame in keyed if frames.first <= frame <= frames.last]
    wanted = sorted({float(frames.first), *inside, float(frames.last)})
    return [_row(shot, frame, frames.first, marks_at(frame), timecode) for frame in wanted]


def _row(
    shot: Shot,
    frame: float,
    first: int,
    marks: Distances,
    timecode: tuple[Timecode, int] | None,
) -> SheetRow:
    lens, rate = shot.lens_at(frame), shot.frames_per_second
    told = ""
    if timecode is not None and timecode[0].fits(rate):
        told = str(timecode[0].later(round(frame) - timecode[1], rate))
    return SheetRow(
        frame=f"{frame:g}",
        timecode=told,
        seconds=f"{(frame - first) / rate:.2f}",
        mark=_mark_at(lens.focus_distance_m, marks),
        focus=format_distance(lens.focus_distance_m, "m"),
        feet=format_distance(lens.focus_distance_m, "ft"),
        near=format_distance(near_limit_m(lens), "m"),
        far=format_distance(far_limit_m(lens), "m"),
        f_stop=f"f/{lens.f_stop:.3g}",
    )


def _mark_at(distance_m: float, marks: Distances) -> str:
    """Return the mark that lies at a distance, the nearest one; "" for none."""
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


def sheet_html(title: str, shot: Shot, rows: Sequence[SheetRow]) -> str:
    """Return the page. Raises InputError where the package that makes it is not installed."""
    jinja2 = import_extra("jinja2", "The pull sheet", "study")
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        undefined=jinja2.StrictUndefined,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    lens = shot.lens
    facts = {
        "lens": f"{lens.focal_length_mm:.4g} mm",
        "film back": f"{lens.sensor_width_mm:.4g} mm wide",
        "rate": f"{shot.frames_per_second:.5g} frames a second",
    }
    page = environment.get_template(_TEMPLATE).render(title=title, facts=facts, rows=rows)
    return str(page)


def write_sheet(path: Path, title: str, shot: Shot, rows: Sequence[SheetRow]) -> Path:
    """Write the page to `path` and the table beside it; return the path of the table."""
    table = path.with_suffix(".csv")
    write_whole(path, sheet_html(title, shot, rows).encode())
    write_whole(table, sheet_csv(rows).encode())
    return table
