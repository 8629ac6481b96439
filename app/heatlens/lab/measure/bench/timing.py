"""Render a plate repeatedly, and time whole frames and each pass, within a time limit."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import count
from statistics import median

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.media.plate.plate import Plate
from heatlens.media.scene.scene import Scene
from heatlens.render.defocus.layer_cuts import layer_cuts
from heatlens.render.defocus.line_solver import SOLVERS, SolverName
from heatlens.render.defocus.plate_passes import proxy_size
from heatlens.render.defocus.quality import layers_for
from heatlens.render.defocus.steps import Steps
from heatlens.render.frame_renderer import FrameRenderer, run_all_steps
from heatlens.render.gpu.context import check_plate_fits, check_work_fits
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Texture
from heatlens.render.gpu.stopwatch import Stopwatch, run_seconds

_F_STOP_STEP = 1e-9  # relative change of the f-stop from frame to frame
_F_STOP_STEPS = count(1)  # shared, so that no two frames have exactly the same lens


@dataclass(frozen=True, slots=True)
class PassSeconds:
    """The seconds of all runs of a pass in a frame, and the number of runs."""

    seconds: float
    runs: int


@dataclass(frozen=True, slots=True)
class FrameSeconds:
    """Medians of whole frames with the stopwatch off and on, and of each pass by name, in order."""

    stopwatch_off: float
    stopwatch_on: float
    passes: dict[str, PassSeconds]


class BenchFrames:
    """Renders plates with a `FrameRenderer` and a chosen solver."""

    def __init__(self, ctx: Device, solver: str) -> None:
        """Make a renderer; `solver` is a name of SOLVERS, or "auto" for that of `render`."""
        # "auto" does not measure which solver is fastest: that built programs for a solver that is
        # not used (0.9 s), and the last digits of a picture depended on the load of the machine.
        self.ctx = ctx
        self.renderer = FrameRenderer(
            ctx, None if solver == "auto" else SOLVERS[SolverName(solver)](ctx)
        )
        self.solver = self.renderer.solver
        self.stopwatch = self.renderer.stopwatch

    def check_fits(self, size: tuple[int, int], settings: DefocusSettings) -> None:
        """Raise GpuError for a picture that is too large for the GPU or for memory.

        Call it before a plate of that size is made.
        """
        check_plate_fits(self.ctx, *size)
        check_work_fits(self.ctx, *proxy_size(size, settings.proxy))

    def frame(self, plate: Plate, lens: Lens, settings: DefocusSettings) -> "Frame":
        """Load `plate` to the GPU; it replaces the previous source."""
        self.renderer.load(plate)
        return Frame(self.renderer, Shot(lens, settings))

    def scene_frame(
        self, scene: Scene, framing: Framing, lens: Lens, settings: DefocusSettings
    ) -> "SceneFrame":
        """Load `scene` to the GPU; it replaces the previous source."""
        self.renderer.load_scene(scene)
        return SceneFrame(self.renderer, Shot(lens, settings, framing=framing))


@dataclass(frozen=True, eq=False)
class Frame:
    """One frame, ready to render; it is valid until another source is loaded.

    enlarges  a small picture may be enlarged, as in the window
    """

    renderer: FrameRenderer
    shot: Shot
    enlarges: bool = False

    def render(self) -> Texture:
        """Issue the frame; the GPU may still be working on it afterwards."""
        return run_all_steps(self.steps())

    def steps(self) -> Steps[Texture]:
        """Render the frame in steps, as `FrameRenderer.steps` does."""
        return self.renderer.steps(self._next_shot(), enlarges=self.enlarges)

    def _next_shot(self) -> Shot:
        return self.shot

    @property
    def layer_count(self) -> int:
        """Number of layers of the picture at its proxy size."""
        settings = self.shot.defocus
        optics = self.renderer.optics(self.shot)
        layers = layers_for(settings)
        return 1 if layers == 1 else len(layer_cuts(optics.occupied_px, optics.gaps_px, layers))


class SceneFrame(Frame):
    """A frame of a scene, rendered anew from all points of the lens each time."""

    def _next_shot(self) -> Shot:
        """Return the shot with a slightly different lens, so that no accumulated view is reused."""
        f_stop = self.shot.lens.f_stop * (1.0 + _F_STOP_STEP * next(_F_STOP_STEPS))
        return replace(self.shot, lens=replace(self.shot.lens, f_stop=f_stop))


def median_seconds(ctx: Device, runs: int, *works: Callable[[], object]) -> list[float]:
    """Return the median seconds of each function, after one warm-up each that builds programs.

    The functions take turns, so that the state of the machine is the same for all.
    """
    for work in works:
        work()
    turns = [[run_seconds(ctx, work) for work in works] for _ in range(runs)]
    return [median(seconds) for seconds in zip(*turns, strict=True)]


def frame_seconds(stopwatch: Stopwatch, runs: int, work: Callable[[], object]) -> FrameSeconds:
    """Time a frame with the stopwatch off and on, in turn, after one warm-up."""
    work()
    stopwatch_off: list[float] = []
    stopwatch_on: list[float] = []
    passes: list[dict[str, PassSeconds]] = []
    for _ in range(runs):
        stopwatch_off.append(run_seconds(stopwatch.ctx, work))
        stopwatch.times.clear()
        stopwatch.is_on = True
        stopwatch_on.append(run_seconds(stopwatch.ctx, work))
        stopwatch.is_on = False
        passes.append(
            {
                name: PassSeconds(pass_time.seconds, pass_time.runs)
                for name, pass_time in stopwatch.times.items()
            }
        )
    medians = {
        name: PassSeconds(
            median(passes_of_run[name].seconds for passes_of_run in passes), entry.runs
        )
        for name, entry in passes[0].items()
    }
    return FrameSeconds(median(stopwatch_off), median(stopwatch_on), medians)


ReportProgress = Callable[[str], None]
LIMIT_S = 20.0  # time limit for one cell of a table, with all its frames


@dataclass(frozen=True, eq=False)
class TimedFrame:
    """The median milliseconds of a frame, and its picture, which the next frame overwrites."""

    ms: float
    picture: Texture


def time_within_limit(frame: Frame, runs: int, limit_s: float) -> TimedFrame | None:
    """Return the median of `runs` frames, or None if even the warm-up exceeds `limit_s`.

    If time is short, the median is of fewer frames or of the warm-up alone.
    """
    end = time.monotonic() + limit_s
    first = _time_first_frame(frame, end)
    if first is None:
        return None
    pictures: list[Texture] = [first.picture]
    seconds: list[float] = []
    while len(seconds) < runs and time.monotonic() + 1e-3 * first.ms < end:
        seconds.append(run_seconds(frame.renderer.ctx, lambda: pictures.append(frame.render())))
    median_s = sorted(seconds)[len(seconds) // 2] if seconds else 1e-3 * first.ms
    return TimedFrame(1e3 * median_s, pictures[-1])


class MethodTimer:
    """Skips methods that have been too slow once, and reports this once."""

    def __init__(self, runs: int, report_progress: ReportProgress) -> None:
        self._runs, self._report_progress = runs, report_progress
        self._too_slow: set[str] = set()

    def time_method(
        self, name: str, make_frame: Callable[[], Frame], blur_text: str
    ) -> TimedFrame | None:
        """Time a frame of `name`, or return None once it has been too slow.

        `make_frame` is called only if the frame is rendered. `blur_text` is part of the message.
        """
        if name in self._too_slow:
            return None
        self._report_progress(f"{name}, {blur_text}")
        result = time_within_limit(make_frame(), self._runs, LIMIT_S)
        if result is None:
            self._report_progress(
                f"{name} skipped from here on: a frame takes more than {LIMIT_S:g} s"
            )
            self._too_slow.add(name)
        return result


def _time_first_frame(frame: Frame, end: float) -> TimedFrame | None:
    """Render a frame step by step; stop after the first step that ends later than `end`."""
    frame.renderer.ctx.finish()
    start = time.monotonic()

    def check_time(_: str) -> None:
        frame.renderer.ctx.finish()
        if time.monotonic() > end:
            raise _TooSlowError

    steps = frame.steps()
    try:
        picture = run_all_steps(steps, check_time)
    except _TooSlowError:
        steps.close()
        return None
    return TimedFrame(1e3 * (time.monotonic() - start), picture)


class _TooSlowError(Exception):
    """A frame has exceeded its time limit."""
