"""Keep how the picture is viewed, and where it lies on the screen."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from heatlens.model.view.display_options import NO_GRADE, DisplayOptions
from heatlens.model.view.view import Compare, ViewState
from heatlens.model.view.view_geometry import ViewGeometry, Viewport
from heatlens.session.pictures.color_choice import ColorChoice
from heatlens.session.shot.editing import Editing


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
        """Return True once the size of the viewport is known."""
        return self.viewport.size[0] > 1.0

    @property
    def is_lens_alone(self) -> bool:
        """True while only the picture through the lens is shown, without comparison or overlay."""
        is_bare = self.state.compare is Compare.OFF and not self.state.has_overlay
        return is_bare and self.state.depth_of_field and not self.is_lens_held_off


class PictureDisplay:
    """View transform, exposure and gamma of the picture that the window shows."""

    def __init__(self, editing: Editing, view: PictureView, color: ColorChoice) -> None:
        self._editing, self.view, self._color = editing, view, color

    def options(self) -> DisplayOptions:
        """Return the look as options of the command line."""
        view = self.view.state.exposed_through(self._editing.lens)
        named = DisplayOptions(
            ocio=self._color.path or None,
            display=view.display or None,
            view=view.view or None,
            input_space=view.input_space or None,
        )
        if self._editing.shot.grade is not None and not view.is_graded:
            named = replace(named, cdl=NO_GRADE)
        look = DisplayOptions() if self._color.config is None else named
        return replace(look, gamma=view.gamma, exposure_stops=view.exposure_stops)

    def encode(self, light: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return scene-linear light (H, W, 3 or 4) as display values."""
        view = self.view.state.exposed_through(self._editing.lens)
        return self._color.transform.apply_cpu(light, view.exposure_stops, view.gamma)
