"""Choose the preview level to render, with pure functions of the settings and predicted times.

The levels are a ladder: the requested picture, and faster substitutes for it. The window uses lower
levels while something moves; `heatlens bench --drag` measures each level.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

from heatlens.core.model.shot.settings import PROXY_MIN, DefocusSettings, Method, Quality
from heatlens.render.defocus.plate_passes import proxy_size
from heatlens.render.defocus.quality import layers_for

Levels = tuple[DefocusSettings, ...]
Predict = Callable[[DefocusSettings], float]  # seconds that a picture takes

# Hysteresis, as shares of the time budget: change to a better level if it takes less than the first
# share, and to a cheaper level if the current one takes more than the second.
_HYSTERESIS = 0.7, 1.3
# Least width of a preview. Of a plate of 1280x720, one of 160x90 has a FLIP of .063 to the picture
# at rest and takes .064 s of a processor, one of 213x120 .050 and .11 s. Pictures of an older focus
# have .1 and more.
_LEAST_WIDTH_PX = 160
# The same of a picture of a 3D scene, which has finer edges and more lamps: of the demo, one of
# 160x90 has a FLIP of .074 and takes .15 s, one of 256x144 .040 and .20 s. A small scene has
# previews of a fifth of its width.
_LEAST_WIDTH_OF_SCENE_PX, _LEAST_SHARE_OF_SCENE = 240, 1 / 5
_FIRST_WIDTH_PX, _FIRST_SAMPLES = 320, 2**26  # of the first picture of all, at most
_DIRECT_MAX_S = 3.0  # a whole picture that takes longer follows an intermediate preview
_DIRECT_MAX_COARSE_S = 0.25  # the same if the plate will soon be refined
_LEAST_SPEEDUP = 3.0  # an intermediate preview must be at least this many times faster


def useful_levels(
    requested: DefocusSettings, size: tuple[int, int], is_of_scene: bool = False
) -> Levels:
    """Return the preview levels that are large enough to be useful for a plate of this size.

    For a plate that is small itself, return the levels of the largest size. `is_of_scene` is True
    for the picture of a 3D scene.
    """
    least_px = float(_LEAST_WIDTH_PX)
    if is_of_scene and not requested.method.needs_scene:
        of_scene_px = min(_LEAST_WIDTH_OF_SCENE_PX, _LEAST_SHARE_OF_SCENE * size[0])
        least_px = max(least_px, of_scene_px)
    levels = cheaper_levels(requested)
    large = tuple(it for it in levels if proxy_size(size, it.proxy)[0] >= least_px)
    return large or tuple(level for level in levels if level.proxy == levels[0].proxy)


# Of a plate of 1280x720 with lamps, a gathered picture of 320x180 has a FLIP of .092 to the picture
# at rest, and a pyramid of 427x240 one of .190, because its lamps are squares. It takes .06 s.
def first_picture_settings(
    requested: DefocusSettings, size: tuple[int, int], widest_px: float
) -> DefocusSettings:
    """Return the settings of the first picture on a machine whose speed is not known yet.

    Drivers take seconds to build the programs of diffusion, and gathering needs only one. The wider
    the largest disc, `widest_px` in the plate, the smaller the picture, so that it stays quick.
    """
    quickest = useful_levels(requested, size)[-1]
    if requested.method.needs_scene:
        return quickest
    samples_at_full_size = size[0] * size[1] * max(widest_px, 1.0) ** 2
    proxy = min(_FIRST_WIDTH_PX / size[0], (_FIRST_SAMPLES / samples_at_full_size) ** (1 / 4))
    proxy = min(requested.proxy, max(proxy, PROXY_MIN))
    return replace(quickest, method=Method.GATHER, proxy=proxy)


def needs_few_programs(
    settings: DefocusSettings, requested: DefocusSettings, size: tuple[int, int]
) -> bool:
    """Return whether such a picture may be the first on a machine, see `first_picture_settings`."""
    if requested.method.needs_scene:
        return settings == useful_levels(requested, size)[-1]
    return settings.method is Method.GATHER


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
