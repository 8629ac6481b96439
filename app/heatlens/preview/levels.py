"""The ladder of preview levels: the requested picture, and faster substitutes for it.

The window uses lower levels while something moves; `heatlens bench --drag` measures each level.
"""

from dataclasses import replace

from heatlens.defocus.quality import layers_for
from heatlens.model.shot.settings import PROXY_MIN, DefocusSettings, Method, Quality

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


def cheaper(requested: DefocusSettings) -> list[DefocusSettings]:
    """Return the requested settings, then faster and faster ones with the same amount of blur."""
    if requested.method.needs_scene:
        return _fewer_views(requested)
    levels = [requested]
    for quality, scale in _CHEAPER:
        level = _level(requested, quality, scale)
        if level not in levels:
            levels.append(level)
    return levels


def _fewer_views(requested: DefocusSettings) -> list[DefocusSettings]:
    levels = [requested]
    for views, scale in (*((n, 1.0) for n in _FULL_VIEWS), *_FEW_VIEWS):
        level = replace(
            requested,
            views=min(views, requested.views),
            proxy=max(PROXY_MIN, requested.proxy * scale),
        )
        if level not in levels:
            levels.append(level)
    return levels


def quickest(requested: DefocusSettings) -> DefocusSettings:
    """Return the settings of the fastest whole picture, for a picture that is small already."""
    method = Method.DIFFUSION if requested.method.needs_scene else requested.method
    return replace(cheaper(replace(requested, method=method))[-1], proxy=1.0)


def on_the_way(requested: DefocusSettings) -> list[DefocusSettings]:
    """Return the settings to show before the whole picture at rest, the fastest first."""
    return _fewer_views(requested)[:0:-1] if requested.method.needs_scene else [between(requested)]


def is_better(one: DefocusSettings, other: DefocusSettings, requested: DefocusSettings) -> bool:
    """Return whether level `one` is closer to the requested picture than `other`."""
    if requested.method.needs_scene:  # any number of views may have been rendered already
        return (one.proxy, one.views) > (other.proxy, other.views)
    levels = cheaper(requested)
    ranks = [levels.index(it) if it in levels else len(levels) for it in (one, other)]
    return ranks[0] < ranks[1]


def between(requested: DefocusSettings) -> DefocusSettings:
    """Return the settings of a smaller picture that is ready sooner."""
    return _level(requested, *_BETWEEN)


def _level(requested: DefocusSettings, best: Quality, scale: float) -> DefocusSettings:
    """Return the settings scaled down, with at most the quality `best` and the same layers."""
    quality = min(best, requested.quality, key=list(Quality).index)
    method = requested.method if requested.method is Method.HEAT else Method.DIFFUSION
    layers = layers_for(replace(requested, method=method))
    return replace(
        requested,
        method=method,
        quality=quality,
        layers=requested.layers if quality is requested.quality else layers,
        parts=1,
        proxy=max(PROXY_MIN, requested.proxy * scale),
    )
