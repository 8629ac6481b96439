"""Write the pull sheet: the focus pulls of shots, for the first assistant on set.

It is a single HTML or PDF file that includes its pictures, and the same rows as CSV.

Its frames are rendered at a small size, and the distances of the marks are measured in them.
"""

import base64
import io
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from itertools import zip_longest
from pathlib import Path

import numpy as np
from PIL import Image

from heatlens.core.base.errors import HeatlensError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.marks.marks import ObjectMark, PointMark
from heatlens.core.model.shot.settings import Method
from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.export.frame_files import RenderedFrame, frame_timecode
from heatlens.deliver.export.job import DisplaySettings, ExportJob
from heatlens.deliver.export.options import ExportOptions
from heatlens.deliver.export.output import parse_output
from heatlens.deliver.export.plan import plan_export
from heatlens.deliver.export.rendering import FrameRendering
from heatlens.deliver.export.sheet_rows import (
    Distances,
    MarkRow,
    SheetRow,
    mark_rows,
    sheet_csv,
    sheet_frames,
    sheet_row,
)
from heatlens.media.files.atomic_file import write_atomically
from heatlens.media.files.html_page import render_page, render_pdf
from heatlens.media.plate.mark_distance import mark_on_plate_m
from heatlens.media.plate.plate import FloatImage, Plate
from heatlens.media.scene.scene_bounds import object_depth_m
from heatlens.render.frame_renderer import FrameRenderer

PURPOSE = "The pull sheet"
_TEMPLATE = Path(__file__).with_name("pull_sheet.html.jinja")
_WIDTH_PX = 480  # twice the width on the page, for print and high-resolution screens
_JPEG_QUALITY = 85
_PROXY = 0.5  # scale of the pictures


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


@dataclass(frozen=True)
class Sheet:
    """The pull of one shot."""

    title: str
    shot: Shot
    entries: Sequence[SheetEntry]

    @property
    def facts(self) -> dict[str, str]:
        """The description of lens and film back."""
        return _lens_facts(self.shot, self.entries)

    @property
    def marks(self) -> list[MarkRow]:
        """The distances of all marks."""
        return mark_rows(self.shot, [entry.marks for entry in self.entries])


def sheet_html(title: str, sheets: Sequence[Sheet]) -> str:
    """Return the page of all shots. Raises InputError if the package for pages is missing."""
    return render_page(_TEMPLATE, {"title": title, "sheets": sheets})


def _lens_facts(shot: Shot, entries: Sequence[SheetEntry]) -> dict[str, str]:
    """Return the description of lens and film back; a zoom is given as a range."""
    frames = [float(entry.row.frame) for entry in entries]
    zoom_frames = [key.frame for key in shot.curves.focal_length_mm.keys]
    frames += [frame for frame in zoom_frames if frames[0] < frame < frames[-1]]
    lengths_mm = [shot.lens_at(frame).focal_length_mm for frame in frames]
    shortest, longest = (f"{length_mm:.4g} mm" for length_mm in (min(lengths_mm), max(lengths_mm)))
    return {
        "lens": shortest if shortest == longest else f"{shortest} to {longest}",
        "film back": f"{shot.lens.sensor_width_mm:.4g} mm wide",
        "distances": f"from the {shot.lens.measured_from.words}",
        "rate": f"{shot.frames_per_second:.5g} frames a second",
    }


def write_sheet(path: Path, title: str, sheets: Sequence[Sheet]) -> Path:
    """Write the page to `path` and the table beside it; return the path of the table.

    Raises InputError if a file cannot be written.
    """
    table, page = path.with_suffix(".csv"), sheet_html(title, sheets)
    write_atomically(
        path, render_pdf(PURPOSE, page) if path.suffix.lower() == ".pdf" else page.encode()
    )
    rows = [(sheet.title, entry.row) for sheet in sheets for entry in sheet.entries]
    shots = [shot for shot, _ in rows] if len(sheets) > 1 else []
    write_atomically(table, sheet_csv([row for _, row in rows], shots).encode())
    return table


def sheet_entries(
    shot: Shot,
    frames: FrameRange,
    display_settings: DisplaySettings,
    make_renderer: Callable[[], FrameRenderer],
) -> Iterator[SheetEntry]:
    """Return a row with a picture for each key of the focus in `frames`, and for both ends.

    Raises InputError for a plate that is damaged, and where the source is not found.
    """
    row_frames = sheet_frames(shot, frames)
    small_defocus = replace(
        shot.defocus, method=Method.DIFFUSION, proxy=min(_PROXY, shot.defocus.proxy)
    )
    whole_frames = tuple(sorted({round(frame) for frame in row_frames}))
    picture_output = parse_output("sheet.####.jpg")  # no path to write: the picture is only shown
    job = ExportJob(
        shot=replace(shot, defocus=small_defocus),
        frames=whole_frames,
        output=picture_output,
        options=ExportOptions(missing="hold"),
        display_settings=display_settings,
    )
    plan = plan_export(job)
    renderer = make_renderer()
    with closing(FrameRendering(plan, plan.frames, renderer)) as rendering:
        by_frame = {frame.frame: frame for frame in plan.frames}
        rendered: RenderedFrame | None = None
        for frame, next_frame in zip_longest(row_frames, row_frames[1:]):
            number = round(frame)
            if rendered is None or rendered.planned.frame != number:
                rendered = rendering.render(by_frame[number])
            marks = mark_distances(shot, renderer, rendered.plate, number)
            timecode = frame_timecode(job, rendered.planned, rendered.plate)
            row = sheet_row(shot, frame, frames.first, marks, timecode, next_frame)
            yield SheetEntry(row, data_uri(rendered.pixels), marks)


def mark_distances(
    shot: Shot, renderer: FrameRenderer, plate: Plate, frame: int
) -> list[tuple[str, float]]:
    """Return the names and distances in meters of the marks that are visible at a frame."""
    distances_m = []
    for mark in shot.marks:
        try:
            distances_m.append((mark.name, _mark_distance_m(shot, renderer, plate, mark, frame)))
        except HeatlensError:  # outside the picture, or no such object
            continue
    return [(name, distance_m) for name, distance_m in distances_m if distance_m > 0.0]


def _mark_distance_m(
    shot: Shot, renderer: FrameRenderer, plate: Plate, mark: Mark, frame: int
) -> float:
    """Return the distance of a mark in meters; 0 if there is none.

    Raises HeatlensError for a mark outside the picture, and for an object that does not exist.
    """
    scene, pose = renderer.scene, renderer.pose_at(shot, frame)
    if isinstance(mark, ObjectMark):
        if scene is None or pose is None:
            return 0.0
        return object_depth_m(scene, mark.object_name, pose, frame)
    known_m = mark.distance_at_m(frame)
    if known_m is not None:
        return known_m
    if scene is None or not isinstance(mark, PointMark):
        return mark_on_plate_m(plate, mark) or 0.0
    return renderer.scene_depth_m(shot, frame, int(mark.x_px), int(mark.y_px))
