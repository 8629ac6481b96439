"""Measure the time of every method against the amount of blur."""

from dataclasses import dataclass
from functools import partial

from heatlens.measure.bench import bounded
from heatlens.measure.bench.bounded import Patience, Say
from heatlens.measure.bench.entrants import entrants
from heatlens.measure.bench.frames import BenchFrames, Frame
from heatlens.measure.bench.synthetic_plate import LENS, uniform_coc_plate
from heatlens.measure.bench.synthetic_scene import uniform_coc_scene, wall_framing
from heatlens.model.settings import DefocusSettings

METHOD_COC_PX = (2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0)


@dataclass(frozen=True, slots=True)
class MethodRow:
    """Milliseconds of a frame by each method's name, with the same coc everywhere.

    They are the median of as many frames as the time limit allowed; None if not even one fitted.
    """

    coc_px: float
    ms: dict[str, float | None]


@dataclass(frozen=True, slots=True)
class MethodReport:
    """All methods over all circles of confusion; `limit_s` is the time limit of each cell."""

    width: int
    height: int
    limit_s: float
    rows: tuple[MethodRow, ...]


def measure_methods(
    frames: BenchFrames, size: tuple[int, int], settings: DefocusSettings, runs: int, say: Say
) -> MethodReport:
    """Measure each method on a plate of uniform coc, or on such a scene if it needs one.

    A method that was too slow once is left out from there on.
    """
    patience, rows = Patience(runs, say), []
    for coc in METHOD_COC_PX:
        ms: dict[str, float | None] = {}
        for name, asked in entrants(settings).items():
            make = partial(_uniform, frames, size, coc, asked)
            timed = patience.timed(name, make, method_where(coc))
            ms[name] = None if timed is None else timed.ms
        rows.append(MethodRow(coc, ms))
    return MethodReport(*size, bounded.LIMIT_S, tuple(rows))


def method_where(coc_px: float) -> str:
    """Return the words after a method's name in progress messages."""
    return f"circle of confusion {coc_px:g} px"


def _uniform(
    frames: BenchFrames, size: tuple[int, int], coc_px: float, settings: DefocusSettings
) -> Frame:
    """Return a frame that has the same coc everywhere."""
    if settings.method.needs_scene:
        scene = uniform_coc_scene(size, coc_px)
        return frames.scene_frame(scene, wall_framing(size), LENS, settings)
    return frames.frame(uniform_coc_plate(size, coc_px), LENS, settings)
