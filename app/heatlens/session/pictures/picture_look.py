"""The look of the picture on the screen, for files that should look the same."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from heatlens.model.guides import Guides
from heatlens.model.look_options import LookOptions
from heatlens.session.pictures.color_choice import ColorChoice
from heatlens.session.pictures.picture_view import PictureView
from heatlens.session.shot.editing import Editing


class PictureLook:
    """View transform, exposure and gamma of the picture that the window shows."""

    def __init__(self, editing: Editing, view: PictureView, color: ColorChoice) -> None:
        self._editing = editing
        self._view = view
        self._color = color

    @property
    def guides(self) -> Guides:
        """The mattes and lines over the picture."""
        return self._view.state.guides

    def options(self) -> LookOptions:
        """Return the look as options of the command line."""
        view = self._view.state.exposed_through(self._editing.lens)
        named = LookOptions(
            ocio=self._color.path or None,
            display=view.display or None,
            view=view.view or None,
            input_space=view.input_space or None,
        )
        look = LookOptions() if self._color.config is None else named
        return replace(look, gamma=view.gamma, exposure_stops=view.exposure_stops)

    def encode(self, light: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return scene-linear light (H, W, 3 or 4) as display values."""
        view = self._view.state.exposed_through(self._editing.lens)
        return self._color.transform.apply_cpu(light, view.exposure_stops, view.gamma)
