"""Write the pull sheet: the focus pull of a shot on one page, for the first assistant on set.

It is a single HTML file that includes its pictures, and the same rows as CSV.
"""

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from heatlens.export.sheet.rows import Distances, SheetRow, mark_rows, sheet_csv
from heatlens.files.atomic_file import write_whole
from heatlens.files.html_page import page_of
from heatlens.model.shot import Shot
from heatlens.plate.plate import FloatImage

PURPOSE = "The pull sheet"
_TEMPLATE = Path(__file__).with_name("pull_sheet.html.jinja")
_WIDTH_PX = 480  # twice the width on the page, for print and high-resolution screens
_JPEG_QUALITY = 85


@dataclass(frozen=True)
class SheetEntry:
    """A row, its picture as a data URI ("" for none), and distances of all marks at its frame."""

    row: SheetRow
    picture: str = ""
    marks: Distances = ()


def data_uri(display: FloatImage) -> str:
    """Return a picture of display values (H, W, 3) in 0..1 as a small JPEG for a page."""
    image = Image.fromarray(np.uint8(np.clip(display, 0.0, 1.0) * 255.0 + 0.5))
    image.thumbnail((_WIDTH_PX, _WIDTH_PX), Image.Resampling.LANCZOS)
    data = io.BytesIO()
    image.save(data, "JPEG", quality=_JPEG_QUALITY)
    return "data:image/jpeg;base64," + base64.b64encode(data.getvalue()).decode()


def sheet_html(title: str, shot: Shot, entries: Sequence[SheetEntry]) -> str:
    """Return the page. Raises InputError if the package that makes it is not installed."""
    marks = mark_rows(shot, [entry.marks for entry in entries])
    values = {"title": title, "facts": _facts(shot, entries), "entries": entries, "marks": marks}
    return page_of(PURPOSE, _TEMPLATE, values)


def _facts(shot: Shot, entries: Sequence[SheetEntry]) -> dict[str, str]:
    """Return the description of lens and film back; a zoom is given as a range."""
    frames = [float(entry.row.frame) for entry in entries]
    zoomed = [key.frame for key in shot.curves.focal_length_mm.keys]
    frames += [frame for frame in zoomed if frames[0] < frame < frames[-1]]
    lengths_mm = [shot.lens_at(frame).focal_length_mm for frame in frames]
    least, most = (f"{it:.4g} mm" for it in (min(lengths_mm), max(lengths_mm)))
    return {
        "lens": least if least == most else f"{least} to {most}",
        "film back": f"{shot.lens.sensor_width_mm:.4g} mm wide",
        "rate": f"{shot.frames_per_second:.5g} frames a second",
    }


def write_sheet(path: Path, title: str, shot: Shot, entries: Sequence[SheetEntry]) -> Path:
    """Write the page to `path` and the table beside it; return the path of the table.

    Raises InputError if a file cannot be written.
    """
    table = path.with_suffix(".csv")
    write_whole(path, sheet_html(title, shot, entries).encode())
    write_whole(table, sheet_csv([entry.row for entry in entries]).encode())
    return table
