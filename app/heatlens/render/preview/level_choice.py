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

# Hysteresis, as shares of the time budget: change to a better level if it takes less than the first
# share, and to a cheaper level if the current one takes more than the second.
_HYSTERESIS = 0.7, 1.3
# Least width of a preview. Of a plate of 1280x720, one of 160x90 has a FLIP of .066 to the picture
# at rest, one of 213x120 of .056, and takes as long: lamps are drawn larger in both.
_LEAST_WIDTH_PX = 200
_LEAST_WIDTH_OF_VIEWS_PX = 160  # the same where each view of a scene is drawn
_DIRECT_MAX_S = 3.0  # a whole picture that takes longer follows an intermediate preview
_DIRECT_MAX_COARSE_S = 0.25  # the same if the plate will soon be refined
_LEAST_SPEEDUP = 3.0  # an intermediate preview must be at least this many times faster
Kind = tuple[Method, Bokeh, Quality, int]  # the last is the number of layers
SizedKind = tuple[Kind, float]  # with the proxy: small pictures cost more for each pixel

_NEWEST_WEIGHT = 0.4  # weight of the newest picture in the running mean of its kind


def useful_levels(requested: DefocusSettings, size: tuple[int, int]) -> Levels:
    """Return the preview levels that are large enough to be useful for a plate of this size.

    For a plate that is small itself, return the levels of the largest size.
    """
    levels = cheaper_levels(requested)
    least = _LEAST_WIDTH_OF_VIEWS_PX if requested.method.needs_scene else _LEAST_WIDTH_PX
    large = tuple(level for level in levels if proxy_size(size, level.proxy)[0] >= least)
    return large or tuple(level for level in levels if level.proxy == levels[0].proxy)


def first_picture_settings(requested: DefocusSettings, size: tuple[int, int]) -> DefocusSettings:
    """Return the settings of the first picture on a machine whose speed is not known yet.

    Drivers take seconds to build the programs of diffusion, and a pyramid needs only two.
    """
    quickest = useful_levels(requested, size)[-1]
    if requested.method.needs_scene:
        return quickest
    return replace(quickest, method=Method.PYRAMID, proxy=min(requested.proxy, 2 * quickest.proxy))


def level_while_moving(
    levels: Levels, previous: DefocusSettings | None, budget_s: float, predict: Predict
) -> DefocusSettings:
    """Return the best of `levels`, which are sorted from best to fastest, that fits the budget.

    The `previous` level stays while it fits approximately; the picture would flicker otherwise.
    """
    fitting = [level for level in levels if predict(level) <= budget_s]
    best = fitting[0] if fitting else levels[-1]
    if previous is None or previous not in levels:
        return best
    if levels.index(best) < levels.index(previous):
        better = levels[: levels.index(previous)]
        fast = (level for level in better if predict(level) <= _HYSTERESIS[0] * budget_s)
        return next(fast, previous)
    return best if predict(previous) > _HYSTERESIS[1] * budget_s else previous


def level_at_rest(
    requested: DefocusSettings,
    shown: DefocusSettings | None,
    is_plate_whole: bool,
    predict: Predict,
) -> DefocusSettings | None:
    """Return the settings to render after the shown preview: the whole picture or a better preview.

    `is_plate_whole` is False if the plate will soon be refined: then return only settings that are
    fast to render, or None.
    """
    whole_s = predict(requested)
    patience_s = _DIRECT_MAX_S if is_plate_whole else _DIRECT_MAX_COARSE_S
    if whole_s <= patience_s and not requested.method.needs_scene:
        return requested
    for level in intermediate_levels(requested):
        is_step_up = shown is None or is_better(level, shown, requested)
        if is_step_up and predict(level) * _LEAST_SPEEDUP < whole_s:
            return level
    return requested if is_plate_whole or requested.method.needs_scene else None


# Times are learnt from pictures, not computed from the passes. The first picture of a kind includes
# the driver's builds, which take seconds; its time counts only until another one is known.
# Otherwise an NVIDIA H200 showed a third of the size while the whole picture takes 5 ms.
@dataclass
class CostModel:
    """Predicts render times from those of earlier pictures.

    It keeps seconds per pixel by kind of picture and scale, for scenes seen from many points of the
    lens seconds per pixel and point. Unknown kinds are estimated from known ones.
    """

    seconds_per_px: dict[SizedKind, float] = field(default_factory=dict)
    with_builds: set[SizedKind] = field(
        default_factory=set
    )  # entries that include a driver's builds
    work_power: float = 1.0  # n times the work takes n ** work_power times as long

    def learn(
        self, settings: DefocusSettings, pixels: int, seconds: float, includes_builds: bool = False
    ) -> None:
        """Learn the time of a picture of `pixels` pixels, and scale all predictions by it.

        Building programs can take a driver hundreds of times as long as the picture. A time that
        `includes_builds` therefore counts only until another one is known.
        """
        sized, new_s_per_px = _sized_kind(settings), seconds / pixels / _view_count(settings)
        if includes_builds:
            if self._known_of_sort(settings):
                return
            self.with_builds.add(sized)
        else:
            self._forget_builds(settings)
        known_s_per_px = self.seconds_per_px.get(sized, new_s_per_px)
        # the ratio by which all known times of this sort of work are changed below
        factor = 1.0 + _NEWEST_WEIGHT * (new_s_per_px / known_s_per_px - 1.0)
        self.seconds_per_px[sized] = known_s_per_px
        for similar in self._known_of_sort(settings):
            self.seconds_per_px[similar] *= factor

    def predict_seconds(self, settings: DefocusSettings, pixels: int) -> float:
        """Return the predicted seconds for a picture of `pixels` pixels; infinite if unknown."""
        known = self._known_of_sort(settings)
        # The cost cannot be predicted if it depends on how large the blur is.
        if settings.method.facts.grows_with_blur or not known:
            return float("inf")
        same_kind = [entry for entry in known if entry[0] == _kind(settings)]
        if not same_kind and settings.method.needs_scene:
            return float("inf")
        work_ratios = {entry: _work(settings) / _work_of(entry) for entry in same_kind or known}
        nearest = min(work_ratios, key=lambda entry: abs(math.log(work_ratios[entry])))
        _, nearest_proxy = nearest
        known_s = self.seconds_per_px[nearest] * pixels * (nearest_proxy / settings.proxy) ** 2
        growth: float = work_ratios[nearest] ** self.work_power
        return known_s * growth * _view_count(settings)

    def _forget_builds(self, settings: DefocusSettings) -> None:
        """Remove the times of the same sort of work that include builds."""
        for entry in self.with_builds.intersection(self._known_of_sort(settings)):
            del self.seconds_per_px[entry]
            self.with_builds.discard(entry)

    def _known_of_sort(self, settings: DefocusSettings) -> list[SizedKind]:
        """Return the known entries for the same sort of work: drawing scenes or blurring plates."""
        is_of_scene = settings.method.needs_scene
        return [entry for entry in self.seconds_per_px if entry[0][0].needs_scene is is_of_scene]


def _view_count(settings: DefocusSettings) -> int:
    """Return how many views of a scene are drawn; 1 for a plate."""
    return settings.views if settings.method.needs_scene else 1


def _sized_kind(settings: DefocusSettings) -> SizedKind:
    """Return the kind of a picture and its scale."""
    return _kind(settings), settings.proxy


def _kind(settings: DefocusSettings) -> Kind:
    """Return the settings that decide the time for each pixel, except the scale."""
    if settings.method.needs_scene:  # no bokeh, no quality, no layers
        return settings.method, Bokeh.DISC, Quality.FILM, 1
    return settings.method, settings.bokeh, settings.effective_quality, layers_for(settings)


def _work(settings: DefocusSettings) -> float:
    """Return the work for a whole picture, or for one view of a scene, to compare settings by."""
    return (1.0 if settings.method.needs_scene else _work_per_pixel(settings)) * settings.proxy**2


def _work_of(sized: SizedKind) -> float:
    """Return the relative work for a picture of this kind and scale."""
    (method, bokeh, quality, layers), proxy = sized
    return _work(DefocusSettings(bokeh, quality, layers, proxy, method))


def _work_per_pixel(settings: DefocusSettings) -> float:
    """Return the relative work for one pixel, in passes over memory.

    A complex pole costs about as much as reading and writing the picture once. A layer adds its
    split, its fill and its composite to its blur.
    """
    kernel, layers = kernel_for(settings), layers_for(settings)
    blur = 1.5 + kernel.steps * len(kernel.poles)
    return blur if layers == 1 else 4.0 + layers * (blur + 2.5)


# The levels from slow to fast: the best quality of each, which sets the number of poles of a disc,
# and its scale relative to the requested picture. Nothing else differs; the lens looks the same at
# every level. One Gaussian layer at a quarter of the size was tried for drags: its FLIP against the
# picture at rest was .199, .242 and .300 on three plates, that of discs in layers at the same size
# .091, .115 and .235.
_CHEAPER_LEVELS: tuple[tuple[Quality, float], ...] = (
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
_INTERMEDIATE = (Quality.PREVIEW, 0.5)
# Levels of a scene seen from many points of the lens, slowest first; at full size, each continues
# from the next lower one.
_FULL_VIEWS = (16384, 4096, 1024, 256, 66, 16)
_FEW_VIEWS = ((16, 1 / 2), (16, 1 / 4), (4, 1 / 4), (4, 1 / 8))  # number of views, and scale


@lru_cache(maxsize=64)  # a window asks several times a frame
def cheaper_levels(requested: DefocusSettings) -> Levels:
    """Return the requested settings, then faster and faster ones with the same amount of blur."""
    if requested.method.needs_scene:
        return _fewer_views(requested)
    levels = [requested]
    for quality, scale in _CHEAPER_LEVELS:
        level = _level(requested, quality, scale)
        if level not in levels:
            levels.append(level)
    return tuple(levels)


def _fewer_views(requested: DefocusSettings) -> Levels:
    """Return the requested settings, then those with fewer views and smaller pictures."""
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


def fastest_settings(requested: DefocusSettings) -> DefocusSettings:
    """Return the settings of the fastest whole picture, for a picture that is small already."""
    method = Method.DIFFUSION if requested.method.needs_scene else requested.method
    return replace(cheaper_levels(replace(requested, method=method))[-1], proxy=1.0)


def intermediate_levels(requested: DefocusSettings) -> Levels:
    """Return the settings to show before the whole picture at rest, the fastest first."""
    if requested.method.needs_scene:
        return cheaper_levels(requested)[:0:-1]
    return (intermediate_level(requested),)


def is_better(level: DefocusSettings, other: DefocusSettings, requested: DefocusSettings) -> bool:
    """Return whether `level` is closer to the requested picture than `other`."""
    if requested.method.needs_scene:  # any number of views may have been rendered already
        return (level.proxy, level.views) > (other.proxy, other.views)
    levels = cheaper_levels(requested)
    rank, other_rank = (levels.index(it) if it in levels else len(levels) for it in (level, other))
    return rank < other_rank


@lru_cache(maxsize=64)
def intermediate_level(requested: DefocusSettings) -> DefocusSettings:
    """Return the settings of a smaller picture that is ready sooner."""
    return _level(requested, *_INTERMEDIATE)


def _level(requested: DefocusSettings, best: Quality, scale: float) -> DefocusSettings:
    """Return the settings scaled down, with at most the quality `best` and the same layers."""
    quality = min(best, requested.effective_quality, key=list(Quality).index)
    method = requested.method if requested.method is Method.HEAT else Method.DIFFUSION
    layers = layers_for(replace(requested, method=method))
    return replace(
        requested,
        method=method,
        quality=quality,
        layers=requested.layers if quality is requested.effective_quality else layers,
        parts=1,
        proxy=max(PROXY_MIN, requested.proxy * scale),
    )
