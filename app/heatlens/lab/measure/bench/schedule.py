"""Plan the measurements of a bench, with estimated times that its pace so far corrects."""

from dataclasses import dataclass

from heatlens.core.base.pace import Step
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.lab.measure.bench import timing
from heatlens.lab.measure.bench.measure import (
    BARE_MESSAGE,
    SWEEP_COC_PX,
    SWEEP_SIZES,
    coc_message,
    copy_message,
    frame_message,
    size_message,
)
from heatlens.lab.measure.bench.method_errors import largest_coc_text, truth_message
from heatlens.lab.measure.bench.methods import METHOD_COC_PX, coc_text, compared_methods
from heatlens.lab.measure.bench.synthetic_plate import LENS, scene_plate
from heatlens.lab.measure.bench.timing import BenchFrames
from heatlens.render.gpu.stopwatch import run_seconds

_PROBE = (320, 180)
# Relative costs in frames of the film picture, which the first measurements correct.
_ONE_LAYER, _BARE, _OTHER_METHOD, _VIEW, _LEVEL = 0.3, 0.5, 0.4, 0.1, 0.4
_COPY_S = 0.3


@dataclass(frozen=True, slots=True)
class RequestedBench:
    """The requested measurements.

    levels  progress messages of the preview levels to measure; empty if not requested
    """

    size: tuple[int, int]
    settings: DefocusSettings
    runs: int
    frame: bool = True
    bare: bool = False
    sweeps: bool = False
    methods: bool = False
    truth_size: tuple[int, int] = (0, 0)
    truth_views: int = 0
    levels: tuple[str, ...] = ()


def probe_seconds_per_px(frames: BenchFrames, settings: DefocusSettings) -> float:
    """Return the seconds per pixel of a small frame, without the time for building programs."""
    frame = frames.frame(scene_plate(_PROBE), LENS, settings)
    frame.render()
    return run_seconds(frames.ctx, frame.render) / (_PROBE[0] * _PROBE[1])


def plan_steps(requested: RequestedBench, seconds_per_px: float) -> tuple[Step, ...]:
    """Return all steps in order; `seconds_per_px` is that of a frame with these settings."""
    frame_s, runs = _pixel_count(requested.size) * seconds_per_px, requested.runs + 1
    steps = [Step(BARE_MESSAGE, runs * _BARE * frame_s)] if requested.bare else []
    if requested.frame:
        steps += [Step(copy_message(requested.size, requested.settings), _COPY_S)]
        steps += [
            Step(frame_message(requested.size, requested.runs), (2 * requested.runs + 1) * frame_s)
        ]
    if requested.sweeps:
        cost = runs * (2.0 + _ONE_LAYER)
        steps += [Step(coc_message(coc), cost * frame_s) for coc in SWEEP_COC_PX]
        cost = runs * (1.0 + _ONE_LAYER) * seconds_per_px
        steps += [Step(size_message(size), cost * _pixel_count(size)) for size in SWEEP_SIZES]
    if requested.methods:
        steps += _method_steps(requested, frame_s)
        steps += _error_steps(requested, _pixel_count(requested.truth_size) * seconds_per_px)
    return (*steps, *(Step(message, runs * _LEVEL * frame_s) for message in requested.levels))


def _method_steps(requested: RequestedBench, frame_s: float) -> list[Step]:
    """Plan each method at each amount of blur."""
    return [
        step for coc in METHOD_COC_PX for step in _cell_steps(requested, coc_text(coc), frame_s)
    ]


def _error_steps(requested: RequestedBench, frame_s: float) -> list[Step]:
    """Plan the truth and each method at each amount of blur; no steps if no truth is requested."""
    if requested.truth_views == 0:
        return []
    steps = []
    for coc in METHOD_COC_PX:
        blur_text = largest_coc_text(coc)
        for views in (max(requested.truth_views // 2, 1), requested.truth_views):
            seconds = requested.truth_views / 2 * _VIEW * frame_s
            steps.append(Step(f"{truth_message(views)}, {blur_text}", seconds))
        steps += _cell_steps(requested, blur_text, frame_s)
    return steps


def _cell_steps(requested: RequestedBench, blur_text: str, frame_s: float) -> list[Step]:
    """Plan each method at one amount of blur, with no more than the time limit for each."""
    steps = []
    for name, settings in compared_methods(requested.settings).items():
        weight = settings.views * _VIEW if settings.method.needs_scene else _OTHER_METHOD
        seconds = min((requested.runs + 1) * weight * frame_s, timing.LIMIT_S)
        steps.append(Step(f"{name}, {blur_text}", seconds))
    return steps


def _pixel_count(size: tuple[int, int]) -> int:
    return size[0] * size[1]
