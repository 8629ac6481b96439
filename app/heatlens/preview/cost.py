"""Predict the render time of a picture on this machine from the pictures rendered before."""

import math
from dataclasses import dataclass, field

from heatlens.defocus.quality import kernel_for, layers_for
from heatlens.model.settings import Bokeh, DefocusSettings, Method, Quality

Kind = tuple[Method, Bokeh, Quality, int]
Sized = tuple[Kind, float]  # with the scale: small pictures cost more for each pixel

_NEWEST = 0.4  # weight of the newest picture in the running mean of its kind


@dataclass
class CostModel:
    """Seconds per pixel by kind of picture and scale; unknown kinds are estimated from known ones.

    For scenes seen from many points of the lens, seconds per pixel and point.
    """

    seconds_per_px: dict[Sized, float] = field(default_factory=dict)

    def learn(self, settings: DefocusSettings, pixels: int, seconds: float) -> None:
        """Learn the time of a picture of `pixels` pixels, and scale all predictions by it."""
        sized, new = _sized(settings), seconds / pixels / _times(settings)
        old = self.seconds_per_px.get(sized, new)
        pace = 1.0 + _NEWEST * (new / old - 1.0)
        self.seconds_per_px[sized] = old
        for other in self._alike(settings):
            self.seconds_per_px[other] *= pace

    def predicted(self, settings: DefocusSettings, pixels: int) -> float:
        """Return the predicted seconds for a picture of `pixels` pixels; infinite if unknown."""
        kind, known = _kind(settings), self._alike(settings)
        # The cost cannot be predicted if it depends on how large the blur is.
        if settings.method.facts.grows_with_blur or not known:
            return float("inf")
        sizes = [size for other, size in known if other == kind]
        if sizes:
            nearest = min(sizes, key=lambda size: abs(math.log(size / settings.proxy)))
            return self.seconds_per_px[kind, nearest] * pixels * _times(settings)
        if settings.method.needs_scene:
            return float("inf")
        weight = _weight(settings)
        guesses = [self.seconds_per_px[it] * weight / _kind_weight(it[0]) for it in known]
        return max(guesses) * pixels

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
    return settings.method, settings.bokeh, settings.quality, layers_for(settings)


def _kind_weight(kind: Kind) -> float:
    method, bokeh, quality, layers = kind
    return _weight(DefocusSettings(bokeh, quality, layers, method=method))


def _weight(settings: DefocusSettings) -> float:
    """Return the relative work for one pixel, in passes over memory.

    A complex pole costs about as much as reading and writing the picture once. A layer adds its
    split, its fill and its composite to its blur.
    """
    kernel, layers = kernel_for(settings), layers_for(settings)
    blur = 1.5 + kernel.steps * len(kernel.poles)
    return blur if layers == 1 else 4.0 + layers * (blur + 2.5)
