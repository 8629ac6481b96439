"""The Export panel's work: wish in, process out, ending said."""

from pathlib import Path
from typing import TYPE_CHECKING

from heatlens.errors import HeatlensError
from heatlens.session.export_process import ExportRun, ExportState
from heatlens.ui.panels.export_panel import Asked, ExportWish, export_panel, wish_for

if TYPE_CHECKING:
    from collections.abc import Callable

    from heatlens.ui.app import App


class Exporter:
    """Exports the shot in hand, as it is when the button is pressed."""

    def __init__(self, app: "App", wake: "Callable[[], None]") -> None:
        self._app = app
        self.run = ExportRun(wake)
        self.wish = ExportWish()
        self._of: str | None = None  # the source that the wish was proposed for
        self._told: ExportState | None = None

    def draw(self) -> None:
        """The panel, inside its window."""
        plate, shot = self._app.source.plate, self._app.shot
        if plate is not None and shot.source != self._of:
            is_single = shot.played is None or shot.played.count == 1
            self.wish, self._of = wish_for(plate.path, is_single), shot.source
        self.wish, asked = export_panel(self.wish, shot.played, self.run.state)
        if asked is Asked.CANCEL:
            self.run.cancel()
        elif asked is not Asked.NOTHING:
            self._begin(asked)

    def _begin(self, asked: Asked) -> None:
        app, view = self._app, self._app.view
        try:
            Path(self.wish.folder).expanduser().mkdir(parents=True, exist_ok=True)
            if asked is Asked.CAMERA:
                self.run.camera(app.shot, self.wish.camera_output)
                return
            stops = view.exposure_stops + app.lens.transmission_stops
            display = view.display if app.color.config is not None else ""
            words = self.wish.words(display, view.view, stops)
            self.run.export(app.shot, self.wish.output, words + self._look_words())
        except OSError as error:
            app.say(f"{self.wish.folder} cannot be made: {error.strerror or error}.")
        except HeatlensError as error:
            app.say(str(error))

    def _look_words(self) -> list[str]:
        """What of the way the picture looks here `ExportWish` does not know."""
        app, view = self._app, self._app.view
        if self.wish.is_linear:
            return []
        words = ["--ocio", app.start.ocio] if app.start.ocio and app.color.config else []
        if view.gamma != 1.0:
            words.append(f"--gamma={view.gamma:g}")
        if app.color.config is not None and view.input_space:
            words.append(f"--input-space={view.input_space}")
        return words

    def poll(self) -> None:
        """Once a frame: say how an export has ended."""
        state = self.run.state
        if state is not None and state.code is not None and state is not self._told:
            self._told = state
            self._app.say(state.said)
