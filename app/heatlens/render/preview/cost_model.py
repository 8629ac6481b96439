"""Predict the render time of a picture on this machine from those rendered before."""

import math
from dataclasses import dataclass, field

from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Method, Quality
from heatlens.render.defocus.quality import kernel_for, layers_for

# The power of the work with which the time of a picture grows on a GPU, which a small picture does
# not fill: measured on an NVIDIA H200 from 1280x720 to 3840x2160.
GPU_WORK_POWER = 0.5

Kind = tuple[Method, Bokeh, Quality, int]  # the last is the number of layers
SizedKind = tuple[Kind, float]  # with the proxy: small pictures cost more for each pixel

_NEWEST_WEIGHT = 0.4  # weight of the newest picture in the running mean of its kind


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

    def has_timed(self, settings: DefocusSettings) -> bool:
        """Return True if a picture of this kind and scale was timed without a driver's builds."""
        sized = _sized_kind(settings)
        return sized in self.seconds_per_px and sized not in self.with_builds

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
