"""The reference of a study: a file, many views of a scene, or diffusion."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from heatlens.measure.compare.pictures import Picture, shared_region
from heatlens.measure.study.subject import Subject
from heatlens.model.boxes import Box
from heatlens.model.shot.settings import Bokeh, DefocusSettings, Method, Quality
from heatlens.plate.plate import FloatImage

_SHARED = "Accumulation shares its first views with the truth, which favours it a little."


@dataclass(frozen=True, eq=False)
class Reference:
    """Scene-linear `pixels` (H, W, 3) over `region`, a box in pixels of the rendered picture.

    name      what it is, in a few words
    is_truth  False where it is one of the methods itself, which may be wrong as well
    note      a sentence on what favours a method, or ""
    """

    pixels: FloatImage
    region: Box
    name: str
    is_truth: bool
    note: str = ""


def from_file(subject: Subject, truth: Picture) -> Reference:
    """Return the finished picture of a file, over the region shared with the subject.

    Raises InputError if their pixel grids differ.
    """
    plate = subject.plate
    data = plate.data_window
    own = Picture(plate.path, plate.color[..., :3], data, plate.display_window)
    shared = shared_region(own, truth)
    x0, y0 = shared.x0 - data.x0, shared.y0 - data.y0
    region = Box(x0, y0, x0 + shared.width, y0 + shared.height)
    return Reference(_finite(truth.over(shared)), region, truth.path.name, is_truth=True)


def truth_settings(subject: Subject, views: int) -> DefocusSettings:
    """Return settings for `views` views through the lens. Raises InputError for too many."""
    return replace(subject.settings(Method.ACCUMULATION), views=views)


def from_views(subject: Subject, views: int, tell: Callable[[str], None]) -> Reference:
    """Render the truth of a scene, exact but for the noise of its views; report to `tell`."""
    settings = truth_settings(subject, views)
    name = f"the scene seen from {views} points of the lens"
    return replace(_rendered(subject.pixels(settings, tell), name, is_truth=True), note=_SHARED)


def from_diffusion(subject: Subject) -> Reference:
    """Render a plate at the best quality, which is not a truth."""
    settings = DefocusSettings(bokeh=Bokeh.DISC, quality=Quality.FILM, method=Method.DIFFUSION)
    return _rendered(subject.pixels(settings), "diffusion, film", is_truth=False)


def announce(reference: Reference, say: Callable[[str], None]) -> None:
    """Warn that the reference is not a truth, and of any bias."""
    if reference.is_truth:
        say(f"truth: {reference.name}")
    else:
        say(
            f"no truth was given: the methods are compared with {reference.name}, which is itself "
            "a method; --truth compares with a finished picture"
        )


def _rendered(rgba: FloatImage, name: str, is_truth: bool) -> Reference:
    height, width = rgba.shape[:2]
    return Reference(_finite(rgba[..., :3]), Box(0, 0, width, height), name, is_truth)


def _finite(rgb: FloatImage) -> FloatImage:
    return np.where(np.isfinite(rgb), rgb, 0).astype(np.float32)
