"""Count the OpenGL calls of a frame, and predict its time on a GPU that need not be present.

Every dispatch, draw and barrier costs a GPU some microseconds, however small the picture is, and a
fast GPU waits while Python issues them. Here the frame is issued to an OpenGL that does none of the
work, so the measured time is that of Python and of binding.
"""

import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import OnUse
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.lab.measure.bench.synthetic_plate import LENS, scene_plate
from heatlens.lab.measure.bench.timing import BenchFrames, Frame
from heatlens.render.defocus.line_solver import SolverName
from heatlens.render.defocus.pass_costs import Work
from heatlens.render.defocus.pass_list import pass_named
from heatlens.render.defocus.plate_passes import proxy_size
from heatlens.render.defocus.quality import kernel_for
from heatlens.render.gpu.context import Gpu, library_of
from heatlens.render.gpu.device import Device

_counting_device = OnUse("render.gpu.opengl.counting", "counting_device")
ISSUE_MESSAGE = "counting what the frame asks of a GPU"
# Microseconds of an issue with its barrier, and of solving the lines of one pixel of a layer on one
# processor: fitted to frames of 1280x720 to 3840x2160 on an NVIDIA H200.
_ISSUE_US, _SOLVED_PIXEL_US = 36.5, 0.0114


@dataclass(frozen=True, slots=True)
class Card:
    """A GPU to predict for: the bytes that it moves in a second, and its processors."""

    name: str
    gb_per_s: float
    processors: int


CARDS = (Card("500 GB/s, 46 processors", 500.0, 46), Card("4 TB/s, 132 processors", 4000.0, 132))


@dataclass(frozen=True, slots=True)
class IssueReport:
    """The OpenGL calls of a frame, and its predicted time.

    issues           dispatches, indirect dispatches, draws and clears together
    uniforms         values set; unchanged ones are not set again
    bytes_per_pixel  upper limit of the memory traffic, with each layer as large as the picture
    python_ms        time to issue the frame, with nothing drawn
    predicted_ms     upper limit by card: the time of the GPU or that of Python, whichever is longer
    """

    layer_count: int
    issues: int
    dispatches: int
    indirect_dispatches: int
    draws: int
    clears: int
    barriers: int
    uniforms: int
    bytes_per_pixel: float
    python_ms: float
    predicted_ms: dict[str, float]


def measure_issues(
    ctx: Device,
    size: tuple[int, int],
    settings: DefocusSettings,
    runs: int,
    report_progress: Callable[[str], None],
) -> IssueReport:
    """Count and time the issues of a frame of the scene at `size` as a GPU would get them.

    Raises InputError for a device of another library than OpenGL.
    """
    if library_of(ctx) is not Gpu.OPENGL:
        raise InputError("--issues counts the calls of OpenGL: leave --gpu wgpu out.")
    # The counting device gets pictures and lists whole, as a GPU does, because issues limit a fast
    # GPU. Slices and bands, which let a window answer while software draws, took 400 dispatches
    # with barriers for a frame of 3840x2160; without them it takes 9, and 15 for each layer.
    report_progress(ISSUE_MESSAGE)
    counts: Counter[str] = Counter()
    frames = BenchFrames(_counting_device(ctx, counts), SolverName.PARTITION)
    frame = frames.frame(scene_plate(size), LENS, settings)
    bytes_per_pixel = _bytes_per_pixel(frames, frame, size, settings)
    seconds = []
    for _ in range(runs):
        counts.clear()
        start = time.perf_counter()
        frame.render()
        seconds.append(time.perf_counter() - start)
    return _report(counts, frame.layer_count, bytes_per_pixel, 1e3 * median(seconds), size)


def _bytes_per_pixel(
    frames: BenchFrames, frame: Frame, size: tuple[int, int], settings: DefocusSettings
) -> float:
    """Return the bytes that all passes of a frame move, by the table of their costs."""
    stopwatch = frames.stopwatch
    stopwatch.is_on = True
    frame.render()
    stopwatch.is_on = False
    working_size = proxy_size(size, settings.proxy)
    work = Work(working_size, kernel_for(settings), SolverName.PARTITION, settings.proxy)
    moved = (
        pass_named(name).traffic(work, pass_time.runs).moved
        for name, pass_time in stopwatch.times.items()
    )
    return sum(filter(None, moved))


def _report(
    counts: Counter[str],
    layer_count: int,
    bytes_per_pixel: float,
    python_ms: float,
    size: tuple[int, int],
) -> IssueReport:
    """Return the report of the counts, with the predicted time on each card."""
    issues = sum(counts[kind] for kind in ("dispatch", "indirect", "draw", "clear"))
    moved_gb = 1e-9 * bytes_per_pixel * size[0] * size[1]
    predicted, solved_pixels = {}, layer_count * size[0] * size[1]
    for card in CARDS:
        waiting_us = issues * _ISSUE_US + solved_pixels * _SOLVED_PIXEL_US / card.processors
        predicted[card.name] = max(1e3 * moved_gb / card.gb_per_s + 1e-3 * waiting_us, python_ms)
    return IssueReport(
        layer_count=layer_count,
        issues=issues,
        dispatches=counts["dispatch"],
        indirect_dispatches=counts["indirect"],
        draws=counts["draw"],
        clears=counts["clear"],
        barriers=counts["barrier"],
        uniforms=counts["uniform"],
        bytes_per_pixel=bytes_per_pixel,
        python_ms=python_ms,
        predicted_ms=predicted,
    )


def issue_lines(report: IssueReport) -> str:
    """Return the report as lines of text."""
    cards = (f"{ms:.1f} ms at {card}" for card, ms in report.predicted_ms.items())
    return (
        f"issues of a frame on a GPU: {report.issues} for {report.layer_count} layers "
        f"({report.dispatches} dispatches, "
        f"{report.indirect_dispatches} indirect, {report.draws} draws, {report.clears} clears), "
        f"{report.barriers} barriers, {report.uniforms} uniforms\n"
        f"Python {report.python_ms:.2f} ms; at most {report.bytes_per_pixel:.0f} bytes a pixel\n"
        f"predicted at most, not measured: {'; '.join(cards)}"
    )
