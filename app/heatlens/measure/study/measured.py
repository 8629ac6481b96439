"""Measure each method for a study: its picture, its distance from the reference, its time.

`Report` is a whole study as a value, for its page and its numbers.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median

import numpy as np

from heatlens.base.errors import GpuError
from heatlens.base.extras import import_extra
from heatlens.measure.bench.frames import run_seconds
from heatlens.measure.compare.metrics import Scores, score
from heatlens.measure.study.subject import Reference, Subject
from heatlens.model.boxes import Box
from heatlens.model.shot.settings import DefocusSettings, Method
from heatlens.plate.plate import FloatImage

LIMIT_S = 60.0  # the runs of one method stop here; its warm-up is always done to the end
Say = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Row:
    """One method: its picture, scene-linear (H, W, 3), and what was measured of it.

    seconds  median of `runs` frames after a warm-up; of the warm-up alone if runs is 0
    """

    method: Method
    detail: str
    pixels: FloatImage
    seconds: float
    runs: int
    scores: Scores


@dataclass(frozen=True)
class Rows:
    """All methods, the nearest to the reference first, and why others are missing."""

    rows: tuple[Row, ...]
    left_out: tuple[str, ...]


def check_measurable() -> None:
    """Raise InputError if the package that measures FLIP is not installed."""
    import_extra("flip_evaluator", "FLIP", "study")


def measure_all(
    subject: Subject, methods: tuple[Method, ...], reference: Reference, runs: int, say: Say
) -> Rows:
    """Measure each method; skip one that needs too much memory, and report it with `say`.

    Raises the GpuError of the last method if none could be rendered.
    """
    rows: list[Row] = []
    left_out: list[str] = []
    for at, method in enumerate(methods, 1):
        say(f"{at} of {len(methods)}: {method}")
        try:
            rows.append(measured(subject, subject.settings(method), reference, runs))
        except GpuError as error:
            if not rows and at == len(methods):
                raise
            left_out.append(f"{method} is skipped: {error}")
            say(left_out[-1])
    return Rows(tuple(sorted(rows, key=lambda row: row.scores.flip)), tuple(left_out))


def measured(subject: Subject, settings: DefocusSettings, reference: Reference, runs: int) -> Row:
    """Render one method, compare it over the reference's region, and time more frames of it."""
    start = time.monotonic()
    subject.forget(settings)
    pixels = cut(subject.pixels(settings), reference.region)
    warm_up = time.monotonic() - start
    seconds = run_times(subject, settings, runs, start + LIMIT_S - warm_up)
    scores = score(pixels, reference.pixels)
    middle = median(seconds or [warm_up])
    return Row(settings.method, detail_of(settings), pixels, middle, len(seconds), scores)


def run_times(
    subject: Subject, settings: DefocusSettings, runs: int, last_start: float
) -> list[float]:
    """Return the seconds of `runs` frames, or fewer if the clock passes `last_start`."""
    seconds: list[float] = []
    while len(seconds) < runs and time.monotonic() < last_start:
        subject.forget(settings)
        seconds.append(run_seconds(subject.renderer.ctx, lambda: subject.draw(settings)))
    return seconds


def cut(rgba: FloatImage, region: Box) -> FloatImage:
    """Return the colour (H, W, 3) of a region, which is in pixels of the picture."""
    rows, columns = slice(region.y0, region.y1), slice(region.x0, region.x1)
    return np.ascontiguousarray(rgba[rows, columns, :3])


def detail_of(settings: DefocusSettings) -> str:
    """Describe the settings that the method uses; return "" if it has none."""
    if settings.method is Method.DIFFUSION:
        layers = "" if settings.layers is None else f", {settings.layers} layers"
        return f"{settings.bokeh}, {settings.at_quality}{layers}"
    unit = settings.method.facts.views_are
    return f"{settings.views} {unit}" if unit else ""


@dataclass(frozen=True, eq=False)
class Report:
    """The values of a whole report: the subject and the results.

    title     the name of the source
    facts     what all the pictures have in common, as (label, value)
    reference the picture that the rows are compared with
    sharp     the picture before the lens (H, W, 3) over the same region, None where there is none
    rows      the methods, the closest to the reference first
    left_out  a sentence for each method that is missing
    crops     places to look at, in pixels of the reference
    gain      factor by which the differences are brightened
    machine   the name of the renderer that the times belong to
    """

    title: str
    facts: tuple[tuple[str, str], ...]
    reference: Reference
    sharp: FloatImage | None
    rows: tuple[Row, ...]
    left_out: tuple[str, ...]
    crops: tuple[Box, ...]
    gain: float
    machine: str

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of all its pictures."""
        return self.reference.region.width, self.reference.region.height

    @property
    def best(self) -> Row:
        """The nearest to the reference, except a method that is the reference itself."""
        if self.reference.is_truth:
            return self.rows[0]
        return next((row for row in self.rows if row.scores.flip > 0), self.rows[0])
