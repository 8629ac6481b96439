"""Choose the preview level to render, with pure functions of the settings and predicted times.

The levels are a ladder: the requested picture, and faster substitutes for it. The window uses lower
levels while something moves; `heatlens bench --drag` measures each level.

`CostModel` predicts the render time of a picture on this machine from those rendered before.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache

from heatlens.core.model.shot.settings import PROXY_MIN, Bokeh, DefocusSettings, Method, Quality
from heatlens.render.defocus.plate_passes import proxy_size
from heatlens.render.defocus.quality import kernel_for, layers_for

# The power of the work with which the time of a picture grows on a GPU, which a small picture does
# not fill: measured on an NVIDIA H200 from 1280x720 to 3840x2160.
GPU_WORK_POWER = 0.5

Levels = tuple[DefocusSettings, ...]
Predict = Callable[[DefocusSettings], float]  # seconds that a picture takes

# Hysteresis, as parts of the time budget: change to a better level below the first number, and to
# a cheaper one above the second.
_KEEP = 0.7, 1.3
_LEAST_WIDTH_PX = 160  # least width of a preview
# The whole picture follows directly if it takes no longer than this,
_PATIENCE_S = 3.0
# or than this if the plate itself will soon be refined,
_SOON_S = 0.25
# or if an intermediate preview is less than this many times faster.
_FAST_ENOUGH = 3.0
Kind = tuple[Method, Bokeh, Quality, int]
Sized = tuple[Kind, float]  # with the scale: small pictures cost more for each pixel

_NEWEST = 0.4  # weight of the newest picture in the running mean of its kind


def recognisable(requested: DefocusSettings, size: tuple[int, int]) -> Levels:
    """Return the preview levels that are large enough to be useful for a plate of this size.

    For a plate that is small itself, return the levels of the largest size.
    """
    levels = cheaper(requested)
    large = tuple(it for it in levels if proxy_size(size, it.proxy)[0] >= _LEAST_WIDTH_PX)
    return large or tuple(it for it in levels if it.proxy == levels[0].proxy)


# The driver's builds decide when the first picture is there: the quickest level of a 1280x720 plate
# came after 3.6 s on a new machine, a pyramid after 0.3 s.
def soonest(requested: DefocusSettings, size: tuple[int, int]) -> DefocusSettings:
    """Return the settings of the first picture on a machine that nothing is known about.

    Drivers take seconds to build the programs of diffusion, and a pyramid needs only two.
    """
    quickest = recognisable(requested, size)[-1]
    if requested.method.needs_scene:
        return quickest
    return replace(quickest, method=Method.PYRAMID, proxy=min(requested.proxy, 2 * quickest.proxy))


def level_while_moving(
    levels: Levels,
    held: DefocusSettings | None,
    budget_s: float,
    predict: Predict,
) -> DefocusSettings:
    """Return the best of `levels`, which are sorted from best to fastest, that fits the budget.

    The previous level `held` is kept while it fits approximately, so that the picture does not
    flicker between two levels.
    """
    fitting = [level for level in levels if predict(level) <= budget_s]
    best = fitting[0] if fitting else levels[-1]
    if held is None or held not in levels:
        return best
    if levels.index(best) < levels.index(held):
        better = levels[: levels.index(held)]
        return next((it for it in better if predict(it) <= _KEEP[0] * budget_s), held)
    return best if predict(held) > _KEEP[1] * budget_s else held


def level_at_rest(
    requested: DefocusSettings,
    shown: DefocusSettings | None,
    is_plate_whole: bool,
    predict: Predict,
) -> DefocusSettings | None:
    """Return the settings to render after the shown preview: the whole picture or a better preview.

    If the plate will soon be refined, return only settings that are fast to render, or None.
    """
    whole_s = predict(requested)
    patience_s = _PATIENCE_S if is_plate_whole else _SOON_S
    if whole_s <= patience_s and not requested.method.needs_scene:
        return requested
    for level in on_the_way(requested):
        is_step_up = shown is None or is_better(level, shown, requested)
        if is_step_up and predict(level) * _FAST_ENOUGH < whole_s:
            return level
    return requested if is_plate_whole or requested.method.needs_scene else None


@dataclass
# Times are learnt, and not computed from the passes. The first picture of a kind contains the
# driver's builds, which are seconds. Taken for its cost, an NVIDIA H200 showed a third of the size
# while the whole picture takes 5 ms; that is why builds count only until another time is known.
class CostModel:
    """Seconds per pixel by kind of picture and scale; unknown kinds are estimated from known ones.

    For scenes seen from many points of the lens, seconds per pixel and point.
    """

    seconds_per_px: dict[Sized, float] = field(default_factory=dict)
    with_builds: set[Sized] = field(default_factory=set)  # those that contain a driver's builds
    work_power: float = 1.0  # n times the work takes n ** work_power times as long

    def learn(
        self, settings: DefocusSettings, pixels: int, seconds: float, has_built: bool = False
    ) -> None:
        """Learn the time of a picture of `pixels` pixels, and scale all predictions by it.

        Building its programs can take a driver hundreds of times as long as the picture. The time
        of a picture that `has_built` some therefore counts only until another one is known.
        """
        sized, new = _sized(settings), seconds / pixels / _times(settings)
        if has_built:
            if self._alike(settings):
                return
            self.with_builds.add(sized)
        else:
            self._forget_builds(settings)
        old = self.seconds_per_px.get(sized, new)
        pace = 1.0 + _NEWEST * (new / old - 1.0)
        self.seconds_per_px[sized] = old
        for other in self._alike(settings):
            self.seconds_per_px[other] *= pace

    def predicted(self, settings: DefocusSettings, pixels: int) -> float:
        """Return the predicted seconds for a picture of `pixels` pixels; infinite if unknown."""
        known = self._alike(settings)
        # The cost cannot be predicted if it depends on how large the blur is.
        if settings.method.facts.grows_with_blur or not known:
            return float("inf")
        own = [it for it in known if it[0] == _kind(settings)]
        if not own and settings.method.needs_scene:
            return float("inf")
        works = {it: _work(settings) / _work_of(it) for it in own or known}
        nearest = min(works, key=lambda it: abs(math.log(works[it])))
        known_s = self.seconds_per_px[nearest] * pixels * (nearest[1] / settings.proxy) ** 2
        growth: float = works[nearest] ** self.work_power
        return known_s * growth * _times(settings)

    def _forget_builds(self, settings: DefocusSettings) -> None:
        for it in self.with_builds.intersection(self._alike(settings)):
            del self.seconds_per_px[it]
            self.with_builds.discard(it)

    def _alike(self, settings: DefocusSettings) -> list[Sized]:
        """Return the known entries for the same sort of work: drawing scenes or blurring plates."""
        is_of_scene = settings.method.needs_scene
        return [it for it in self.seconds_per_px if it[0][0].needs_scene is is_of_scene]


def _times(settings: DefocusSettings) -> int:
    return settings.views if settings.method.needs_scene else 1


def _sized(settings: DefocusSettings) -> Sized:
    return _kind(settings), settings.proxy


def _kind(settings: DefocusSettings) -> Kind:
    if settings.method.needs_scene:  # no bokeh, no quality, no layers
        return settings.method, Bokeh.DISC, Quality.FILM, 1
    return settings.method, settings.bokeh, settings.at_quality, layers_for(settings)


def _work(settings: DefocusSettings) -> float:
    """Return the relative work for a whole picture, or for one view of a scene."""
    return (1.0 if settings.method.needs_scene else _weight(settings)) * settings.proxy**2


def _work_of(sized: Sized) -> float:
    (method, bokeh, quality, layers), proxy = sized
    return _work(DefocusSettings(bokeh, quality, layers, proxy, method))


def _weight(settings: DefocusSettings) -> float:
    """Return the relative work for one pixel, in passes over memory.

    A complex pole costs about as much as reading and writing the picture once. A layer adds its
    split, its fill and its composite to its blur.
    """
    kernel, layers = kernel_for(settings), layers_for(settings)
    blur = 1.5 + kernel.steps * len(kernel.poles)
    return blur if layers == 1 else 4.0 + layers * (blur + 2.5)


# One Gaussian layer at a quarter of the size was tried for drags. Against the picture at rest its
# FLIP was .199, .242 and .300 on three plates, and that of discs in layers at the same size .091,
# .115 and .235: a pull is judged by the shape of the blur.
# From slow to fast: the best quality of each level, which sets the number of poles of a disc, and
# its scale relative to the requested picture. Nothing else differs, so that the lens looks the same
# at every level.
_CHEAPER: tuple[tuple[Quality, float], ...] = (
    (Quality.PREVIEW, 1.0),
    (Quality.PREVIEW, 1 / 2),
    (Quality.PREVIEW, 1 / 3),
    (Quality.PREVIEW, 1 / 4),
    (Quality.DRAFT, 1 / 4),
    (Quality.DRAFT, 1 / 5),
    (Quality.DRAFT, 1 / 6),
    (Quality.DRAFT, 1 / 8),
)
# The picture shown between a fast preview and a whole picture that takes long.
_BETWEEN = (Quality.PREVIEW, 0.5)
# Levels of a scene seen from many points of the lens, slowest first; at full size, each continues
# from the next lower one.
_FULL_VIEWS = (16384, 4096, 1024, 256, 66, 16)
_FEW_VIEWS = ((16, 1 / 2), (16, 1 / 4), (4, 1 / 4), (4, 1 / 8))  # number of views, and scale


@lru_cache(maxsize=64)  # a window asks several times a frame
def cheaper(requested: DefocusSettings) -> Levels:
    """Return the requested settings, then faster and faster ones with the same amount of blur."""
    if requested.method.needs_scene:
        return _fewer_views(requested)
    levels = [requested]
    for quality, scale in _CHEAPER:
        level = _level(requested, quality, scale)
        if level not in levels:
            levels.append(level)
    return tuple(levels)


def _fewer_views(requested: DefocusSettings) -> Levels:
    levels = [requested]
    for views, scale in (*((n, 1.0) for n in _FULL_VIEWS), *_FEW_VIEWS):
        level = replace(
            requested,
            views=min(views, requested.views),
            proxy=max(PROXY_MIN, requested.proxy * scale),
        )
        if level not in levels:
            levels.append(level)
    return tuple(levels)


def quickest(requested: DefocusSettings) -> DefocusSettings:
    """Return the settings of the fastest whole picture, for a picture that is small already."""
    method = Method.DIFFUSION if requested.method.needs_scene else requested.method
    return replace(cheaper(replace(requested, method=method))[-1], proxy=1.0)


def on_the_way(requested: DefocusSettings) -> Levels:
    """Return the settings to show before the whole picture at rest, the fastest first."""
    return cheaper(requested)[:0:-1] if requested.method.needs_scene else (between(requested),)


def is_better(one: DefocusSettings, other: DefocusSettings, requested: DefocusSettings) -> bool:
    """Return whether level `one` is closer to the requested picture than `other`."""
    if requested.method.needs_scene:  # any number of views may have been rendered already
        return (one.proxy, one.views) > (other.proxy, other.views)
    levels = cheaper(requested)
    ranks = [levels.index(it) if it in levels else len(levels) for it in (one, other)]
    return ranks[0] < ranks[1]


@lru_cache(maxsize=64)
def between(requested: DefocusSettings) -> DefocusSettings:
    """Return the settings of a smaller picture that is ready sooner."""
    return _level(requested, *_BETWEEN)


def _level(requested: DefocusSettings, best: Quality, scale: float) -> DefocusSettings:
    """Return the settings scaled down, with at most the quality `best` and the same layers."""
    quality = min(best, requested.at_quality, key=list(Quality).index)
    method = requested.method if requested.method is Method.HEAT else Method.DIFFUSION
    layers = layers_for(replace(requested, method=method))
    return replace(
        requested,
        method=method,
        quality=quality,
        layers=requested.layers if quality is requested.at_quality else layers,
        parts=1,
        proxy=max(PROXY_MIN, requested.proxy * scale),
    )
