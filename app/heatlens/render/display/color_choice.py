"""Choose the view transform by name and rebuild it on change; its faults are only reported."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.messages import report_errors
from heatlens.core.model.shot.grade import Grade
from heatlens.core.model.view.view import ViewState
from heatlens.media.color.color_config import ColorConfig, default_view, load_color_config
from heatlens.media.color.input_space import InputSpace, input_space_of
from heatlens.media.color.view_transform import srgb_transform, view_transform
from heatlens.render.display.screen_pictures import ScreenPictures

_NO_REQUEST = ("", "", None, None)  # no view has such an input space


class ColorChoice:
    """Keeps the display pass set to the chosen display and view."""

    def __init__(self, path: str | None, notify: Callable[[str], None]) -> None:
        """Load the config at `path`, None for $OCIO or the built-in one. Raises InputError."""
        self._notify = notify
        self.path = path
        self.config: ColorConfig | None = None
        try:
            self.config = load_color_config(path)
        except HeatlensError as error:
            if path is not None:
                raise
            notify(f"{error} Pictures are shown through the plain sRGB curve.")
        self._inputs = self.config.input_spaces() if self.config else ()
        self.attributes: Mapping[str, object] = {}  # header entries of the open plate
        self._applied: tuple[str, str, InputSpace | None, Grade | None] = _NO_REQUEST
        self.transform = srgb_transform()  # the transform in use

    def displays(self) -> tuple[str, ...]:
        """Return the displays to choose from."""
        return self.config.displays() if self.config else ("sRGB",)

    def views(self, display: str) -> tuple[str, ...]:
        """Return the views to choose from for a display."""
        return self.config.views(display) if self.config else ("sRGB curve",)

    def input_spaces(self) -> tuple[str, ...]:
        """Return the input color spaces to choose from, the default one first.

        The plain sRGB curve has none: it uses the color space of the header.
        """
        return self._inputs

    def usual_view(self, display: str) -> str:
        """Return the default view of a display for the open plate, the same as in `render`."""
        if self.config is None:
            return self.views(display)[0]
        return default_view(self.config, display, self.attributes)

    def adapt_to_plate(self, view: ViewState, attributes: Mapping[str, object]) -> ViewState:
        """Use the header of a plate; return `view` with its usual view, unless one was chosen."""
        old_default = self.usual_view(view.display)
        self.attributes = attributes
        return (
            replace(view, view=self.usual_view(view.display)) if view.view == old_default else view
        )

    def chosen_view(self, view: ViewState) -> str:
        """Return the view that the user chose; "" if it is the default one."""
        return "" if view.view == self.usual_view(view.display) else view.view

    def limit_to_config(self, view: ViewState) -> ViewState:
        """Return `view` with display, view and input space limited to those of the config."""
        displays = self.displays()
        if view.display not in displays:
            default_display = self.config.default_display if self.config else displays[0]
            view = replace(view, display=default_display, view="")
        if view.view not in self.views(view.display):
            view = replace(view, view=self.usual_view(view.display))
        return view if view.input_space in self._inputs else replace(view, input_space="")

    def plate_input_space(self, chosen_space: str) -> InputSpace:
        """Return the input space of the plate: `chosen_space`, else that of its header."""
        return input_space_of(self.config, self.attributes, chosen_space)

    def rebuild(self) -> None:
        """Build the transform again at the next `apply`."""
        self._applied = _NO_REQUEST

    def apply(self, view: ViewState, screen: ScreenPictures, grade: Grade | None = None) -> None:
        """Set the transform that `view` names on `screen`, with the grade of the shot.

        Report a transform that cannot be built.
        """
        input_space = self.plate_input_space(view.input_space)
        grade = grade if view.is_graded else None
        requested = (view.display, view.view, input_space, grade)
        if requested == self._applied:
            return
        self._applied = requested
        with report_errors(self._notify):
            if self.config is None:
                transform = srgb_transform(input_space.name, input_space.source_primaries)
            else:
                transform = view_transform(
                    *(self.config, view.display, view.view, input_space.name),
                    *(input_space.source_primaries, grade),
                )
            screen.display.set_transform(transform)
            self.transform = transform
        screen.transform_version += 1
