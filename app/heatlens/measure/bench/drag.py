"""Measure preview levels as seen while dragging: pictures per second, and error to rest."""

import math
from dataclasses import dataclass, replace

import numpy as np

from heatlens.base.errors import InputError
from heatlens.defocus.kernels import Kernel
from heatlens.defocus.plate_passes import proxy_size
from heatlens.defocus.quality import kernel_for
from heatlens.measure.bench import bounded
from heatlens.measure.bench.bounded import Say
from heatlens.measure.bench.drag_view import DragView, Shown
from heatlens.measure.bench.frames import BenchFrames, Frame
from heatlens.measure.compare.metrics import flip_evaluation
from heatlens.model.lens import Lens
from heatlens.model.settings import DefocusSettings
from heatlens.plate.plate import Plate
from heatlens.preview.levels import cheaper

_BLACK = np.zeros((16, 16, 3), np.float32)


@dataclass(frozen=True, slots=True)
class DragRow:
    """One level of the ladder, the first being the picture at rest.

    ms and pictures_per_s  None where a picture took longer than the limit
    flip                   mean LDR-FLIP to the picture at rest, None where it was not measured
    """

    width: int
    height: int
    quality: str
    poles: int
    layer_count: int
    ms: float | None
    pictures_per_s: float | None
    flip: float | None


@dataclass(frozen=True, slots=True)
class DragReport:
    """All levels; `flip_missing` says why there is no FLIP, else it is ""."""

    source: str
    width: int
    height: int
    renderer: str
    rows: tuple[DragRow, ...]
    flip_missing: str


def level_words(settings: DefocusSettings, size: tuple[int, int]) -> str:
    """Return the progress message of a level; `size` is that of the plate."""
    width, height = proxy_size(size, settings.proxy)
    return f"level {width}x{height}, {settings.quality}"


def measure_drag(
    frames: BenchFrames, plate: Plate, lens: Lens, settings: DefocusSettings, runs: int, say: Say
) -> DragReport:
    """Return time and FLIP of every level that the window may show of this picture."""
    missing = flip_missing()
    if missing:
        say(missing)
    frame = frames.frame(plate, lens, settings)
    full = frame.renderer.loaded.color.size
    size = proxy_size(full, settings.proxy)
    view = DragView(frame.renderer, size)
    rest, rows = None, []
    for level in cheaper(settings):
        say(level_words(level, full))
        row, shown = _row(frame, level, view, runs, None if missing else rest)
        rest = shown if rest is None else rest
        rows.append(row)
    view.release()
    renderer = str(frames.ctx.info["GL_RENDERER"])
    return DragReport(str(plate.path), *size, renderer, tuple(rows), missing)


def flip_missing() -> str:
    """Return why FLIP cannot be measured here; "" if it can."""
    try:
        flip_evaluation(_BLACK, _BLACK, "LDR")
    except InputError as error:
        return f"FLIP is left out: {error}"
    return ""


def _row(
    frame: Frame, level: DefocusSettings, view: DragView, runs: int, rest: Shown | None
) -> tuple[DragRow, Shown | None]:
    """Measure one preview level and its picture; the picture is None if it took too long."""
    here = replace(frame, shot=replace(frame.shot, defocus=level))
    timed = bounded.bounded(here, runs, bounded.LIMIT_S)
    shown = flip = None
    if timed is not None:
        shown = view.moving(timed.picture, here.shot, frame.shot.defocus.proxy)
        flip = None if rest is None else float(flip_evaluation(shown, rest, "LDR")[1])
    ms = None if timed is None else timed.ms
    kernel: Kernel = kernel_for(level)
    size = proxy_size(frame.renderer.loaded.color.size, level.proxy)
    rate = None if ms is None or not ms > 0.0 else 1e3 / ms
    row = DragRow(*size, str(level.quality), len(kernel.poles), here.layer_count, ms, rate, flip)
    return row, shown


def drag_table(report: DragReport) -> str:
    """Return the levels as a text table."""
    lines = [
        f"drag: {report.source}, {report.width}x{report.height} at rest; {report.renderer}",
        "level        pixels  quality   poles  layers        ms  pictures/s  FLIP to rest",
    ]
    for number, row in enumerate(report.rows):
        name = "at rest" if number == 0 else str(number)
        flip = "-" if row.flip is None else f"{row.flip:.4f}"
        lines.append(
            f"{name:8}{f'{row.width}x{row.height}':>11}  {row.quality:8}{row.poles:7d}"
            f"{row.layer_count:8d}{_cell(row.ms, 10)}{_cell(row.pictures_per_s, 12)}{flip:>14}"
        )
    if report.flip_missing:
        lines.append(report.flip_missing)
    return "\n".join(lines)


def _cell(value: float | None, width: int) -> str:
    return f"{'too slow' if value is None or math.isnan(value) else format(value, '.1f'):>{width}}"
