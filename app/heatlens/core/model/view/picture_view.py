"""Keep how a picture is viewed, and where it lies on the screen."""

from dataclasses import dataclass, field

from heatlens.core.model.view.view import Compare, ViewState
from heatlens.core.model.view.view_geometry import ViewGeometry, Viewport


@dataclass
class PictureView:
    """The view state, which panels and commands replace, and the position of the picture.

    state             exposure, overlay, comparison, zoom
    viewport          the rectangle of the window that the picture is drawn in
    geometry          maps pixels of the picture to the viewport
    is_lens_held_off  a held key shows the pinhole picture
    """

    state: ViewState = field(default_factory=ViewState)
    viewport: Viewport = field(default_factory=lambda: Viewport((0.0, 0.0), (1.0, 1.0)))
    geometry: ViewGeometry = field(default_factory=lambda: ViewGeometry((0.0, 0.0), (1.0, 1.0)))
    is_lens_held_off: bool = False

    @property
    def zoom(self) -> float:
        """Screen pixels for one pixel of the picture."""
        return self.geometry.per_px[1] * self.viewport.framebuffer_scale

    @property
    def is_drawn(self) -> bool:
        """True once the size of the viewport is known."""
        return self.viewport.size[0] > 1.0

    @property
    def is_lens_alone(self) -> bool:
        """True while only the picture through the lens is shown, without comparison or overlay."""
        has_nothing_over = self.state.compare is Compare.OFF and not self.state.has_overlay
        return has_nothing_over and self.state.depth_of_field and not self.is_lens_held_off
