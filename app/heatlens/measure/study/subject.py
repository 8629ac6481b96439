"""The subject of a study: one frame of a plate or scene through one lens, blurred in many ways.

It is held against a reference: a file, many views of a scene, or diffusion.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from heatlens.gpu.textures import download
from heatlens.measure.compare.pictures import Picture, shared_region
from heatlens.model.boxes import Box
from heatlens.model.shot.settings import Bokeh, DefocusSettings, Method, Quality
from heatlens.model.shot.shot import Shot
from heatlens.plate.plate import FloatImage, Plate
from heatlens.render import FrameRenderer, drained

_SHARED = "Accumulation shares its first views with the truth, which favours it a little."


@dataclass(frozen=True, eq=False)
class Subject:
    """A renderer with the source loaded, and the frame to render.

    All methods use the lens of `shot`. Its settings are those of diffusion, and give the number of
    views for methods that need a scene.
    """

    name: str
    renderer: FrameRenderer
    shot: Shot
    frame: int = 0

    @property
    def methods(self) -> tuple[Method, ...]:
        """Every method that the source allows, in the order of `Method`."""
        return self.renderer.methods

    @property
    def plate(self) -> Plate:
        """The picture without a lens; of a scene, as seen from the lens's centre."""
        return self.renderer.look(self.shot, self.frame).plate

    @property
    def machine(self) -> str:
        """The name of the OpenGL renderer."""
        return str(self.renderer.ctx.info["GL_RENDERER"])

    def settings(self, method: Method) -> DefocusSettings:
        """Return the settings of the shot with another method."""
        return replace(self.shot.defocus, method=method)

    def pixels(
        self, settings: DefocusSettings, tell: Callable[[str], None] = lambda _: None
    ) -> FloatImage:
        """Render the picture, (H, W, 4) float32, premultiplied; `tell` is called at each step."""
        steps = self.renderer.steps(replace(self.shot, defocus=settings), self.frame)
        return download(drained(steps, tell))

    def draw(self, settings: DefocusSettings) -> None:
        """Issue the picture; the GPU may still be working on it."""
        self.renderer.render(replace(self.shot, defocus=settings), self.frame)

    def forget(self, settings: DefocusSettings) -> None:
        """Make a method that accumulates start again, by rendering one view of another lens."""
        if settings.method.needs_scene:
            lens = replace(self.shot.lens, f_stop=0.8 * self.shot.lens.f_stop)
            other = replace(self.shot, lens=lens, defocus=replace(settings, views=1))
            self.renderer.render(other, self.frame)


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
