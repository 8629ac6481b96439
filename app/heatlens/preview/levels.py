"""The ladder of preview levels: the wished picture, and quicker ones that stand in for it.

The window goes down the ladder while something moves; `heatlens bench --drag` measures each level.
"""

from dataclasses import replace

from heatlens.model.settings import PROXY_MIN, Bokeh, DefocusSettings, Method, Quality

# Cheaper and cheaper: quality, layers (None: as the quality says) and size against the wished one.
_CHEAPER: tuple[tuple[Quality, int | None, float], ...] = (
    (Quality.PREVIEW, None, 1.0),
    (Quality.DRAFT, None, 1.0),
    (Quality.DRAFT, None, 0.5),
    (Quality.DRAFT, None, 1 / 3),
    (Quality.DRAFT, 1, 0.5),
    (Quality.DRAFT, 1, 1 / 3),
    (Quality.DRAFT, 1, 1 / 4),
    (Quality.DRAFT, 1, 1 / 6),
    (Quality.DRAFT, 1, 1 / 8),
)
# What is shown on the way from a hurried picture to the whole.
_BETWEEN = (Quality.DRAFT, None, 0.5)
# Of a scene through many points of the lens, dearest first; at full size each goes on from the next
# one below it.
_FULL_VIEWS = (16384, 4096, 1024, 256, 66, 16)
_FEW_VIEWS = ((16, 1 / 2), (16, 1 / 4), (4, 1 / 4), (4, 1 / 8))  # how many, at which size


def cheaper(wished: DefocusSettings) -> list[DefocusSettings]:
    """The wished picture, then ever quicker ones with the same amount of blur."""
    if wished.method.needs_scene:
        return _fewer_views(wished)
    rank = list(Quality).index
    rungs = [wished]
    for quality, layers, scale in _CHEAPER:
        rung = _rung(wished, quality, layers, scale)
        if rank(quality) <= rank(wished.quality) and rung not in rungs:
            rungs.append(rung)
    return rungs


def _fewer_views(wished: DefocusSettings) -> list[DefocusSettings]:
    rungs = [wished]
    for views, scale in (*((n, 1.0) for n in _FULL_VIEWS), *_FEW_VIEWS):
        rung = replace(
            wished,
            views=min(views, wished.views),
            proxy=max(PROXY_MIN, wished.proxy * scale),
        )
        if rung not in rungs:
            rungs.append(rung)
    return rungs


def on_the_way(wished: DefocusSettings) -> list[DefocusSettings]:
    """What may be shown before the wished picture while nobody drags, quickest first."""
    return _fewer_views(wished)[:0:-1] if wished.method.needs_scene else [between(wished)]


def is_better(one: DefocusSettings, other: DefocusSettings, wished: DefocusSettings) -> bool:
    """Whether `one`, a rung of the wished picture, comes closer to it than `other`."""
    if wished.method.needs_scene:  # any number of views may be seen already
        return (one.proxy, one.views) > (other.proxy, other.views)
    rungs = cheaper(wished)
    ranks = [rungs.index(it) if it in rungs else len(rungs) for it in (one, other)]
    return ranks[0] < ranks[1]


def between(wished: DefocusSettings) -> DefocusSettings:
    """A picture with layers that comes sooner than the wished one."""
    return _rung(wished, *_BETWEEN)


def _rung(
    wished: DefocusSettings, quality: Quality, layers: int | None, scale: float
) -> DefocusSettings:
    given = wished.layers
    fewer = layers if given is None or layers is None else min(layers, given)
    return replace(
        wished,
        bokeh=_hurried_bokeh(wished.bokeh) if layers == 1 else wished.bokeh,
        method=wished.method if wished.method is Method.HEAT else Method.DIFFUSION,
        quality=quality,
        layers=given if layers is None else fewer,
        proxy=max(PROXY_MIN, wished.proxy * scale),
    )


def _hurried_bokeh(wished: Bokeh) -> Bokeh:
    """A disc of few poles rings around lamps, which one layer does not draw: rather a soft spot."""
    return Bokeh.GAUSSIAN if wished is Bokeh.DISC else wished
