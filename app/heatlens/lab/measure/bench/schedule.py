"""Estimate how long a bench will take from its plan, and from its pace so far."""

from dataclasses import dataclass

from heatlens.core.base.pace import Step
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.lab.measure.bench import timing
from heatlens.lab.measure.bench.measure import (
    BARE_WORDS,
    SWEEP_COC_PX,
    SWEEP_SIZES,
    coc_words,
    copy_words,
    frame_words,
    size_words,
)
from heatlens.lab.measure.bench.method_errors import truth_where, truth_words
from heatlens.lab.measure.bench.methods import METHOD_COC_PX, entrants, method_where
from heatlens.lab.measure.bench.synthetic_plate import LENS, scene_plate
from heatlens.lab.measure.bench.timing import BenchFrames
from heatlens.render.gpu.stopwatch import run_seconds

_PROBE = (320, 180)
# Relative costs in frames of the film picture, which the first measurements correct.
_ONE_LAYER, _BARE, _OTHER_METHOD, _VIEW, _LEVEL = 0.3, 0.5, 0.4, 0.1, 0.4
_COPY_S = 0.3


@dataclass(frozen=True, slots=True)
class Asked:
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


def planned(asked: Asked, seconds_per_px: float) -> tuple[Step, ...]:
    """Return all parts in order; `seconds_per_px` is that of a frame with these settings."""
    frame_s, runs = _pixels(asked.size) * seconds_per_px, asked.runs + 1
    steps = [Step(BARE_WORDS, runs * _BARE * frame_s)] if asked.bare else []
    if asked.frame:
        steps += [Step(copy_words(asked.size, asked.settings), _COPY_S)]
        steps += [Step(frame_words(asked.size, asked.runs), (2 * asked.runs + 1) * frame_s)]
    if asked.sweeps:
        each = runs * (2.0 + _ONE_LAYER)
        steps += [Step(coc_words(coc), each * frame_s) for coc in SWEEP_COC_PX]
        each = runs * (1.0 + _ONE_LAYER) * seconds_per_px
        steps += [Step(size_words(size), each * _pixels(size)) for size in SWEEP_SIZES]
    if asked.methods:
        steps += _of_methods(asked, frame_s)
        steps += _of_errors(asked, _pixels(asked.truth_size) * seconds_per_px)
    return (*steps, *(Step(it, runs * _LEVEL * frame_s) for it in asked.levels))


def _of_methods(asked: Asked, frame_s: float) -> list[Step]:
    return [step for coc in METHOD_COC_PX for step in _cells(asked, method_where(coc), frame_s)]


def _of_errors(asked: Asked, frame_s: float) -> list[Step]:
    if asked.truth_views == 0:
        return []
    steps = []
    for coc in METHOD_COC_PX:
        where = truth_where(coc)
        for views in (max(asked.truth_views // 2, 1), asked.truth_views):
            seconds = asked.truth_views / 2 * _VIEW * frame_s
            steps.append(Step(f"{truth_words(views)}, {where}", seconds))
        steps += _cells(asked, where, frame_s)
    return steps


def _cells(asked: Asked, where: str, frame_s: float) -> list[Step]:
    """Plan each method at one amount of blur, with no more than the time limit for each."""
    steps = []
    for name, settings in entrants(asked.settings).items():
        weight = settings.views * _VIEW if settings.method.needs_scene else _OTHER_METHOD
        seconds = min((asked.runs + 1) * weight * frame_s, timing.LIMIT_S)
        steps.append(Step(f"{name}, {where}", seconds))
    return steps


def _pixels(size: tuple[int, int]) -> int:
    return size[0] * size[1]
