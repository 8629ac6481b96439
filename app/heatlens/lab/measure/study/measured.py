"""Measure each method for a study: its picture, its distance from the reference, its time.

The subject of a study is one frame of a plate or scene through one lens, blurred in many ways. It
is held against a reference: a file, many views of a scene, or diffusion.

`Report` is a whole study as a value, for its page and its numbers.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from statistics import median

import numpy as np

from heatlens.core.base.errors import GpuError
from heatlens.core.model.boxes import Box
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.lab.measure.compared_pictures import Picture, shared_region
from heatlens.lab.measure.metrics import Scores, finite, score
from heatlens.media.plate.plate import FloatImage, Plate
from heatlens.render.frame_renderer import FrameRenderer, run_all_steps
from heatlens.render.gpu.stopwatch import run_seconds
from heatlens.render.gpu.textures import download

_SHARED_VIEWS_NOTE = (
    "Accumulation shares its first views with the truth, which favours it a little."
)


@dataclass(frozen=True, eq=False)
class Subject:
    """A renderer with the source loaded, and the frame to render.

    All methods use the lens of `shot`. Its settings are those of diffusion, and give the number of
    views for methods that need a scene.
    """

    name: str
    renderer: FrameRenderer
    shot: Shot
    frame: int = 0

    @property
    def methods(self) -> tuple[Method, ...]:
        """Every method that the source allows, in the order of `Method`."""
        return self.renderer.methods

    @property
    def plate(self) -> Plate:
        """The picture without a lens; of a scene, as seen from the lens's centre."""
        return self.renderer.load_pinhole(self.shot, self.frame).plate

    @property
    def machine(self) -> str:
        """The name of the device that draws."""
        return self.renderer.ctx.name

    def settings(self, method: Method) -> DefocusSettings:
        """Return the settings of the shot with another method."""
        return replace(self.shot.defocus, method=method)

    def pixels(
        self, settings: DefocusSettings, report_step: Callable[[str], None] = lambda _: None
    ) -> FloatImage:
        """Render the picture, (H, W, 4) float32, premultiplied; call `report_step` at each step."""
        steps = self.renderer.steps(replace(self.shot, defocus=settings), self.frame)
        return download(run_all_steps(steps, report_step))

    def draw(self, settings: DefocusSettings) -> None:
        """Issue the picture; the GPU may still be working on it."""
        self.renderer.render(replace(self.shot, defocus=settings), self.frame)

    def forget(self, settings: DefocusSettings) -> None:
        """Make a method that accumulates start again, by rendering one view of another lens."""
        if settings.method.needs_scene:
            lens = replace(self.shot.lens, f_stop=0.8 * self.shot.lens.f_stop)
            shot = replace(self.shot, lens=lens, defocus=replace(settings, views=1))
            self.renderer.render(shot, self.frame)


@dataclass(frozen=True, eq=False)
class Reference:
    """Scene-linear `pixels` (H, W, 3) over `region`, a box in pixels of the rendered picture.

    name      what it is, in a few words
    is_truth  False where it is one of the methods itself, which may be wrong as well
    note      a sentence on what favors a method, or ""
    """

    pixels: FloatImage
    region: Box
    name: str
    is_truth: bool
    note: str = ""


def from_file(subject: Subject, truth: Picture) -> Reference:
    """Return the finished picture of a file, over the region shared with the subject.

    Raises InputError if their pixel grids differ.
    """
    plate = subject.plate
    data = plate.data_window
    plate_picture = Picture(plate.path, plate.color[..., :3], data, plate.display_window)
    shared = shared_region(plate_picture, truth)
    region = shared.relative_to(data)
    return Reference(finite(truth.crop(shared)), region, truth.path.name, is_truth=True)


def truth_settings(subject: Subject, views: int) -> DefocusSettings:
    """Return settings for `views` views through the lens. Raises InputError for too many."""
    return replace(subject.settings(Method.ACCUMULATION), views=views)


def from_views(subject: Subject, views: int, report_step: Callable[[str], None]) -> Reference:
    """Render the truth of a scene, which is exact except for the noise of its views."""
    settings = truth_settings(subject, views)
    name = f"the scene seen from {views} points of the lens"
    return replace(
        _whole_reference(subject.pixels(settings, report_step), name, is_truth=True),
        note=_SHARED_VIEWS_NOTE,
    )


def from_diffusion(subject: Subject) -> Reference:
    """Render a plate at the best quality, which is not a truth."""
    settings = DefocusSettings(bokeh=Bokeh.DISC, quality=Quality.FILM, method=Method.DIFFUSION)
    return _whole_reference(subject.pixels(settings), "diffusion, film", is_truth=False)


def announce(reference: Reference, report_progress: Callable[[str], None]) -> None:
    """Warn that the reference is not a truth, and of any bias."""
    if reference.is_truth:
        report_progress(f"truth: {reference.name}")
    else:
        report_progress(
            f"no truth was given: the methods are compared with {reference.name}, which is itself "
            "a method; --truth compares with a finished picture"
        )


def _whole_reference(rgba: FloatImage, name: str, is_truth: bool) -> Reference:
    """Return a rendered picture (H, W, 4) as the reference over its whole area."""
    height, width = rgba.shape[:2]
    return Reference(finite(rgba[..., :3]), Box(0, 0, width, height), name, is_truth)


LIMIT_S = 60.0  # the runs of one method stop here; its warm-up is always done to the end
ReportProgress = Callable[[str], None]


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


def measure_all(
    subject: Subject,
    methods: tuple[Method, ...],
    reference: Reference,
    runs: int,
    report_progress: ReportProgress,
) -> Rows:
    """Measure each method; skip one that needs too much memory, with a progress message.

    Raises the GpuError of the last method if none could be rendered.
    """
    rows: list[Row] = []
    left_out: list[str] = []
    for number, method in enumerate(methods, 1):
        report_progress(f"{number} of {len(methods)}: {method}")
        try:
            rows.append(measure_method(subject, subject.settings(method), reference, runs))
        except GpuError as error:
            if not rows and number == len(methods):
                raise
            left_out.append(f"{method} is skipped: {error}")
            report_progress(left_out[-1])
    return Rows(tuple(sorted(rows, key=lambda row: row.scores.flip)), tuple(left_out))


def measure_method(
    subject: Subject, settings: DefocusSettings, reference: Reference, runs: int
) -> Row:
    """Render one method, compare it over the reference's region, and time more frames of it."""
    start = time.monotonic()
    subject.forget(settings)
    pixels = crop_color(subject.pixels(settings), reference.region)
    warm_up = time.monotonic() - start
    seconds = run_times(subject, settings, runs, start + LIMIT_S - warm_up)
    scores = score(pixels, reference.pixels)
    median_s = median(seconds or [warm_up])
    return Row(
        method=settings.method,
        detail=detail_of(settings),
        pixels=pixels,
        seconds=median_s,
        runs=len(seconds),
        scores=scores,
    )


def run_times(
    subject: Subject, settings: DefocusSettings, runs: int, last_start_s: float
) -> list[float]:
    """Return the seconds of `runs` frames, or fewer: none begins after `last_start_s`.

    That is a time of the monotonic clock.
    """
    seconds: list[float] = []
    while len(seconds) < runs and time.monotonic() < last_start_s:
        subject.forget(settings)
        seconds.append(run_seconds(subject.renderer.ctx, lambda: subject.draw(settings)))
    return seconds


def crop_color(rgba: FloatImage, region: Box) -> FloatImage:
    """Return the color (H, W, 3) of a region, which is in pixels of the picture."""
    rows, columns = slice(region.y0, region.y1), slice(region.x0, region.x1)
    return np.ascontiguousarray(rgba[rows, columns, :3])


def detail_of(settings: DefocusSettings) -> str:
    """Describe the settings that the method uses; return "" if it has none."""
    if settings.method is Method.DIFFUSION:
        layers = "" if settings.layers is None else f", {settings.layers} layers"
        return f"{settings.bokeh}, {settings.effective_quality}{layers}"
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
        # Without a truth, the reference is one of the methods, which equals itself.
        if self.reference.is_truth:
            return self.rows[0]
        return next((row for row in self.rows if row.scores.flip > 0), self.rows[0])
