"""The ladder of preview levels: the wished picture, and quicker ones that stand in for it.

The window goes down the ladder while something moves; `heatlens bench --drag` measures each level.
"""

from dataclasses import replace

from heatlens.defocus.quality import layers_for
from heatlens.model.settings import PROXY_MIN, DefocusSettings, Method, Quality

# Each picture is quicker than the one before it: the best quality that it may have, which sets the
# number of poles of a disc, and its size against the wished one. Nothing else differs, so that the
# hand sees the same lens at every level.
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
# The picture that is shown on the way from a hurried one to a whole one that takes long.
_BETWEEN = (Quality.PREVIEW, 0.5)
# Of a scene through many points of the lens, dearest first; at full size each goes on from the next
# one below it.
_FULL_VIEWS = (16384, 4096, 1024, 256, 66, 16)
_FEW_VIEWS = ((16, 1 / 2), (16, 1 / 4), (4, 1 / 4), (4, 1 / 8))  # how many, at which size


def cheaper(wished: DefocusSettings) -> list[DefocusSettings]:
    """Return the wished picture, then faster and faster ones with the same amount of blur."""
    if wished.method.needs_scene:
        return _fewer_views(wished)
    levels = [wished]
    for quality, scale in _CHEAPER:
        level = _level(wished, quality, scale)
        if level not in levels:
            levels.append(level)
    return levels


def _fewer_views(wished: DefocusSettings) -> list[DefocusSettings]:
    levels = [wished]
    for views, scale in (*((n, 1.0) for n in _FULL_VIEWS), *_FEW_VIEWS):
        level = replace(
            wished,
            views=min(views, wished.views),
            proxy=max(PROXY_MIN, wished.proxy * scale),
        )
        if level not in levels:
            levels.append(level)
    return levels


def quickest(wished: DefocusSettings) -> DefocusSettings:
    """Return the blur of a whole picture that is there at once, for one that is small already."""
    method = Method.DIFFUSION if wished.method.needs_scene else wished.method
    return replace(cheaper(replace(wished, method=method))[-1], proxy=1.0)


def on_the_way(wished: DefocusSettings) -> list[DefocusSettings]:
    """Return what may be shown before the wished picture while nobody drags, the fastest first."""
    return _fewer_views(wished)[:0:-1] if wished.method.needs_scene else [between(wished)]


def is_better(one: DefocusSettings, other: DefocusSettings, wished: DefocusSettings) -> bool:
    """Return whether level `one` comes closer to the wished picture than `other` does."""
    if wished.method.needs_scene:  # any number of views may be seen already
        return (one.proxy, one.views) > (other.proxy, other.views)
    levels = cheaper(wished)
    ranks = [levels.index(it) if it in levels else len(levels) for it in (one, other)]
    return ranks[0] < ranks[1]


def between(wished: DefocusSettings) -> DefocusSettings:
    """Return a smaller picture that is ready sooner than the wished one."""
    return _level(wished, *_BETWEEN)


def _level(wished: DefocusSettings, best: Quality, scale: float) -> DefocusSettings:
    """Return the wished picture smaller, at most as good as `best`, with the same layers."""
    quality = min(best, wished.quality, key=list(Quality).index)
    method = wished.method if wished.method is Method.HEAT else Method.DIFFUSION
    layers = layers_for(replace(wished, method=method))
    return replace(
        wished,
        method=method,
        quality=quality,
        layers=wished.layers if quality is wished.quality else layers,
        proxy=max(PROXY_MIN, wished.proxy * scale),
    )
