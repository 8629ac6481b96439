"""The subject of a study: one frame of a plate or scene through one lens, blurred in many ways."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from heatlens.gpu.textures import download
from heatlens.model.shot.settings import DefocusSettings, Method
from heatlens.model.shot.shot import Shot
from heatlens.plate.plate import FloatImage, Plate
from heatlens.render import FrameRenderer, drained


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
