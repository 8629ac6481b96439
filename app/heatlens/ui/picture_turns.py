"""Whose turn it is: first the picture in hand, then the frames of the pull, if they are wanted."""

from typing import TYPE_CHECKING

from heatlens.errors import HeatlensError
from heatlens.faults import faults_told
from heatlens.preview.shown import Shown

if TYPE_CHECKING:
    from heatlens.ui.app import App


class PictureTurns:
    """Chooses the picture that is seen, and who works on the next one."""

    def __init__(self, app: "App") -> None:
        self._app = app
        self.is_lens_held_off = False  # by a key, to see the pinhole picture

    @property
    def seen(self) -> Shown | None:
        """The picture through the lens: rendered now, or before where that is not there yet."""
        app, now = self._app, self._app.live.shown
        is_there = now is not None and now.frame == app.frame and not app.scheduler.is_working
        if is_there and app.source.is_settled_at(app.frame) and not app.pull.is_alone:
            return now
        return app.pull.screen.shown() or now

    def update(self) -> None:
        """Answer a change of the shot with a picture that fits the time."""
        app = self._app
        if app.pull.is_alone:
            return
        try:
            with faults_told("The picture could not be made"):
                app.scheduler.wish(app.view, app.shot, app.frame, app.budget_s)
        except HeatlensError as error:
            app.say_error(error)

    @property
    def is_working(self) -> bool:
        """There is a picture to go on with."""
        app = self._app
        return not app.pull.is_alone and (app.scheduler.is_working or app.pull.has_work)

    def work(self) -> None:
        """Go on for a moment."""
        app = self._app
        try:
            with faults_told("The picture could not be made"):
                if app.scheduler.is_working:
                    app.scheduler.work()
                else:
                    app.pull.work()
        except HeatlensError as error:
            app.say_error(error)

    @property
    def version(self) -> object:
        """Another one whenever there is something new to be seen."""
        return self._app.scheduler.version, self._app.pull.version

    def seconds_until_needed(self) -> float | None:
        """How long the loop may sleep; None: until something changes."""
        app = self._app
        if app.pull.is_alone:
            return None
        if app.scheduler.is_working:
            return app.scheduler.seconds_until_needed()
        return app.pull.seconds_until_needed()
