"""What a picture will cost on this machine, learnt from the pictures that were made before it."""

from dataclasses import dataclass, field

from heatlens.defocus.quality import kernel_for, layers_for
from heatlens.model.settings import Bokeh, DefocusSettings, Method, Quality

Kind = tuple[Method, Bokeh, Quality, int]  # everything but the size

# Nobody knows what the next picture costs of a method whose work grows with the blur.
_GROWS_WITH_BLUR = (Method.GATHER, Method.SCATTER)
_NEWEST = 0.4  # weight of the newest picture in the running mean of its kind


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
