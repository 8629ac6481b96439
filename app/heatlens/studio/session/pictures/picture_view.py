"""Tell how the window displays its pictures, for files that look the same."""

from dataclasses import replace

from heatlens.core.model.view.picture_view import PictureView
from heatlens.core.model.view.view import NO_GRADE, DisplayOptions
from heatlens.render.display.color_choice import ColorChoice
from heatlens.render.display.display_values import DisplayValues
from heatlens.render.gpu.device import Device
from heatlens.studio.session.shot.editing import Editing


class PictureDisplay:
    """View transform, exposure and gamma of the picture that the window shows."""

    def __init__(self, editing: Editing, view: PictureView, color: ColorChoice) -> None:
        self._editing, self.view, self._color = editing, view, color

    def options(self) -> DisplayOptions:
        """Return the look as options of the command line."""
        view = self.view.state.with_transmission(self._editing.lens)
        named_options = DisplayOptions(
            ocio=self._color.path or None,
            display=view.display or None,
            view=view.view or None,
            input_space=view.input_space or None,
        )
        if self._editing.shot.grade is not None and not view.is_graded:
            named_options = replace(named_options, cdl=NO_GRADE)
        options = DisplayOptions() if self._color.config is None else named_options
        return replace(options, gamma=view.gamma, exposure_stops=view.exposure_stops)

    def values(self, ctx: Device) -> DisplayValues:
        """Return what converts scene-linear light to the display values of the window."""
        view = self.view.state.with_transmission(self._editing.lens)
        return DisplayValues(ctx, self._color.transform, view.exposure_stops, view.gamma)
