"""Choose the preview level to render, with pure functions of the settings and predicted times.

`CostModel` predicts the render time of a picture on this machine from those rendered before.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from heatlens.defocus.plate_passes import proxy_size
from heatlens.defocus.quality import kernel_for, layers_for
from heatlens.model.shot.settings import Bokeh, DefocusSettings, Method, Quality
from heatlens.preview.levels import cheaper, is_better, on_the_way

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


def recognisable(requested: DefocusSettings, size: tuple[int, int]) -> list[DefocusSettings]:
    """Return the preview levels that are large enough to be useful for a plate of this size.

    For a plate that is small itself, return the levels of the largest size.
    """
    levels = cheaper(requested)
    large = [it for it in levels if proxy_size(size, it.proxy)[0] >= _LEAST_WIDTH_PX]
    return large or [it for it in levels if it.proxy == levels[0].proxy]


def soonest(requested: DefocusSettings, size: tuple[int, int]) -> DefocusSettings:
    """Return the settings of the first picture on a machine that nothing is known about.

    Drivers take seconds to build the programs of diffusion, and a pyramid needs only two.
    """
    quickest = recognisable(requested, size)[-1]
    if requested.method.needs_scene:
        return quickest
    return replace(quickest, method=Method.PYRAMID, proxy=min(requested.proxy, 2 * quickest.proxy))


def level_while_moving(
    levels: list[DefocusSettings],
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
        return best if predict(best) <= _KEEP[0] * budget_s else held
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
