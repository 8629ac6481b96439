"""Every method against the amount of blur: which stay the same, which grow with the disc."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from heatlens.bench.frames import BenchFrames, Frame, run_seconds
from heatlens.bench.synthetic_plate import LENS, uniform_coc_plate
from heatlens.bench.synthetic_scene import uniform_coc_scene, wall_framing
from heatlens.model.settings import DefocusSettings, Method

METHOD_COC_PX = (2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0)
LIMIT_S = 20.0  # what one cell of the table may take, all its frames together


@dataclass(frozen=True, slots=True)
class MethodRow:
    """Milliseconds of a frame by each method's name, the same coc everywhere.

    Median of as many frames as the limit left time for; None where not one was done within it.
    """

    coc_px: float
    ms: dict[str, float | None]


@dataclass(frozen=True, slots=True)
class MethodReport:
    """All methods over all circles of confusion.

    limit_s   what each cell was given
    views     points of the lens that the methods of scenes looked through
    """

    width: int
    height: int
    limit_s: float
    views: int
    rows: tuple[MethodRow, ...]


def measure_methods(
    frames: BenchFrames,
    size: tuple[int, int],
    settings: DefocusSettings,
    runs: int,
    say: Callable[[str], None],
) -> MethodReport:
    """Each method on a plate of one coc, or a scene of it for those that need one.

    One that was too slow once is left out from there on.
    """
    too_slow: set[Method] = set()
    rows = []
    for coc in METHOD_COC_PX:
        ms: dict[str, float | None] = dict.fromkeys(map(str, Method))
        for method in [m for m in Method if m not in too_slow]:
            say(f"{method}, circle of confusion {coc:g} px")
            frame = _uniform(frames, size, coc, replace(settings, method=method))
            ms[method] = bounded_ms(frame, runs, LIMIT_S)
            if ms[method] is None:
                say(f"{method} skipped from here on: a frame takes more than {LIMIT_S:g} s")
                too_slow.add(method)
        rows.append(MethodRow(coc, ms))
    return MethodReport(*size, LIMIT_S, settings.views, tuple(rows))


def _uniform(
    frames: BenchFrames, size: tuple[int, int], coc_px: float, settings: DefocusSettings
) -> Frame:
    """A frame with one coc everywhere."""
    if settings.method.needs_scene:
        scene = uniform_coc_scene(size, coc_px)
        return frames.scene_frame(scene, wall_framing(size), LENS, settings)
    return frames.frame(uniform_coc_plate(size, coc_px), LENS, settings)


def bounded_ms(frame: Frame, runs: int, limit_s: float) -> float | None:
    """Median of `runs` frames, of fewer or of the warm-up alone where time is short, or None."""
    end = time.monotonic() + limit_s
    warm_up = _first_seconds(frame, end)
    if warm_up is None:
        return None
    seconds: list[float] = []
    while len(seconds) < runs and time.monotonic() + warm_up < end:
        seconds.append(run_seconds(frame.renderer.ctx, frame.render))
    return 1e3 * sorted(seconds or [warm_up])[len(seconds) // 2]


def _first_seconds(frame: Frame, end: float) -> float | None:
    """A frame step by step, given up after the step in which `end` passes."""
    frame.renderer.ctx.finish()
    start = time.monotonic()
    steps = frame.renderer.steps(frame.shot)
    for _ in steps:
        frame.renderer.ctx.finish()
        if time.monotonic() > end:
            steps.close()
            return None
    return time.monotonic() - start


def method_table(report: MethodReport) -> str:
    """Aligned: a row for each circle of confusion, a column for each method, "skipped" in words."""
    names = list(report.rows[0].ms)
    head = (
        f"methods at {report.width}x{report.height}, ms a frame, the same circle of confusion "
        f"everywhere, scenes from {report.views} points of the lens; skipped: more than "
        f"{report.limit_s:g} s"
    )
    lines = [head, "    px" + "".join(f"{name:>13}" for name in names)]
    lines += [
        f"{row.coc_px:6g}" + "".join(_cell(row.ms[name]) for name in names) for row in report.rows
    ]
    return "\n".join(lines)


def _cell(ms: float | None) -> str:
    return f"{'skipped':>13}" if ms is None else f"{ms:13.1f}"
