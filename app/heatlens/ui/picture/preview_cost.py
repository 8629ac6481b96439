"""What a picture will cost, learnt from those that were made, and the best one for a given time."""

from dataclasses import dataclass, field, replace

from heatlens.defocus.quality import kernel_for, layers_for
from heatlens.model.settings import PROXY_MIN, Bokeh, DefocusSettings, Method, Quality

Kind = tuple[Method, Bokeh, Quality, int]  # everything but the size

# Nobody knows what the next picture costs of a method whose work grows with the blur.
_GROWS_WITH_BLUR = (Method.GATHER, Method.SCATTER)
_NEWEST = 0.4  # weight of the newest picture in the running mean of its kind
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


@dataclass
class CostModel:
    """Seconds a pixel by kind of picture; kinds not yet met are guessed from one that was.

    Of a scene through many points of the lens: seconds a pixel and point.
    """

    seconds_per_px: dict[Kind, float] = field(default_factory=dict)

    def learn(self, settings: DefocusSettings, pixels: int, seconds: float) -> None:
        """A picture of so many pixels took so long."""
        kind, new = _kind(settings), seconds / pixels / _times(settings)
        old = self.seconds_per_px.get(kind, new)
        self.seconds_per_px[kind] = old + _NEWEST * (new - old)

    def predicted(self, settings: DefocusSettings, pixels: int) -> float:
        """Seconds for a picture of so many pixels; infinite where nothing is known."""
        kind = _kind(settings)
        if settings.method in _GROWS_WITH_BLUR:
            return float("inf")
        if kind in self.seconds_per_px:
            return self.seconds_per_px[kind] * pixels * _times(settings)
        if settings.method.needs_scene:
            return float("inf")
        guesses = [
            per_px * _weight(settings) / _kind_weight(known)
            for known, per_px in self.seconds_per_px.items()
            if not known[0].needs_scene
        ]
        return max(guesses) * pixels if guesses else float("inf")


def _times(settings: DefocusSettings) -> int:
    return settings.views if settings.method.needs_scene else 1


def _kind(settings: DefocusSettings) -> Kind:
    if settings.method.needs_scene:  # no bokeh, no quality, no layers
        return settings.method, Bokeh.DISC, Quality.FILM, 1
    return settings.method, settings.bokeh, settings.quality, layers_for(settings)


def _kind_weight(kind: Kind) -> float:
    method, bokeh, quality, layers = kind
    return _weight(DefocusSettings(bokeh, quality, layers, method=method))


def _weight(settings: DefocusSettings) -> float:
    """Work for one pixel, in passes over memory; only ratios count.

    A complex pole weighs about as much as reading and writing the picture; a layer brings its
    split, its fill and its composite besides its blur.
    """
    kernel, layers = kernel_for(settings), layers_for(settings)
    blur = 1.5 + kernel.steps * len(kernel.poles)
    return blur if layers == 1 else 4.0 + layers * (blur + 2.5)
