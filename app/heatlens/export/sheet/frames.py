"""Render the frames of a pull sheet at a small size, and measure the distances of the marks."""

from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from itertools import zip_longest

from heatlens.base.errors import HeatlensError
from heatlens.export.frame_files import RenderedFrame, frame_timecode
from heatlens.export.job import DisplayLook, ExportJob
from heatlens.export.options import ExportOptions
from heatlens.export.output import parse_output
from heatlens.export.plan import planned
from heatlens.export.rendering import FrameRendering
from heatlens.export.sheet.page import SheetEntry, data_uri
from heatlens.export.sheet.rows import sheet_frames, sheet_row
from heatlens.model.frames import FrameRange
from heatlens.model.marks import DistanceMark, Mark, ObjectMark
from heatlens.model.settings import Method
from heatlens.model.shot import Shot
from heatlens.plate.focus_pick import depth_at_m
from heatlens.plate.plate import Plate
from heatlens.render import FrameRenderer
from heatlens.scene.scene_bounds import object_depth_m

_PROXY = 0.5  # scale of the pictures


def sheet_entries(
    shot: Shot, frames: FrameRange, look: DisplayLook, make_renderer: Callable[[], FrameRenderer]
) -> Iterator[SheetEntry]:
    """Return a row with a picture for each key of the focus in `frames`, and for both ends.

    Raises InputError for a plate that is damaged, and where the source is not found.
    """
    wanted = sheet_frames(shot, frames)
    small = replace(shot.defocus, method=Method.DIFFUSION, proxy=min(_PROXY, shot.defocus.proxy))
    whole = tuple(sorted({round(frame) for frame in wanted}))
    shown = parse_output("sheet.####.jpg")  # nothing is written there: it is a picture for the eye
    job = ExportJob(replace(shot, defocus=small), whole, shown, ExportOptions(missing="hold"), look)
    plan = planned(job)
    renderer = make_renderer()
    with closing(FrameRendering(plan, plan.frames, renderer)) as rendering:
        by_frame = {frame.frame: frame for frame in plan.frames}
        rendered: RenderedFrame | None = None
        for frame, after in zip_longest(wanted, wanted[1:]):
            number = round(frame)
            if rendered is None or rendered.planned.frame != number:
                rendered = rendering.rendered(by_frame[number])
            marks = _distances(shot, renderer, rendered.plate, number)
            told = frame_timecode(job, rendered.planned, rendered.plate)
            row = sheet_row(shot, frame, frames.first, marks, told, after)
            yield SheetEntry(row, data_uri(rendered.pixels), marks)


def _distances(
    shot: Shot, renderer: FrameRenderer, plate: Plate, frame: int
) -> list[tuple[str, float]]:
    """Return the distances in metres of the marks that are visible at a frame."""
    found = []
    for mark in shot.marks:
        try:
            found.append((mark.name, _distance_m(shot, renderer, plate, mark, frame)))
        except HeatlensError:  # outside the picture, or no such object
            continue
    return [(name, distance_m) for name, distance_m in found if distance_m > 0.0]


def _distance_m(shot: Shot, renderer: FrameRenderer, plate: Plate, mark: Mark, frame: int) -> float:
    if isinstance(mark, DistanceMark):
        return mark.distance_m
    scene, pose = renderer.scene, renderer.pose_at(shot, frame)
    if isinstance(mark, ObjectMark):
        if scene is None or pose is None:
            return 0.0
        return object_depth_m(scene, mark.object_name, pose, frame)
    x, y = int(mark.x_px), int(mark.y_px)
    return depth_at_m(plate, x, y) if scene is None else renderer.scene_depth_m(shot, frame, x, y)
