"""Whose turn it is: first the picture in hand, then the frames of the pull, if they are wanted."""

from collections.abc import Callable

from heatlens.errors import HeatlensError
from heatlens.faults import faults_told
from heatlens.preview.shown import Shown
from heatlens.session.editing import Editing
from heatlens.session.live_picture import LivePicture
from heatlens.session.open_source import OpenSource
from heatlens.session.picture_view import PictureView
from heatlens.session.render_scheduler import RenderScheduler
from heatlens.session.rendered_pull import RenderedPull
from heatlens.session.speed import Speed


class PictureTurns:
    """Chooses the picture that is seen, and who works on the next one."""

    def __init__(
        self,
        scheduler: RenderScheduler,
        pull: RenderedPull,
        source: OpenSource,
        editing: Editing,
        view: PictureView,
        live: LivePicture,
        speed: Speed,
        say_error: Callable[[HeatlensError], None],
    ) -> None:
        self._scheduler = scheduler
        self._pull = pull
        self._source = source
        self._editing = editing
        self._view = view
        self._live = live
        self._speed = speed
        self._say_error = say_error

    @property
    def seen(self) -> Shown | None:
        """The picture through the lens: rendered now, or before where that is not there yet."""
        now = self._live.shown
        is_there = (
            now is not None and now.frame == self._editing.frame and not self._scheduler.is_working
        )
        if is_there and self._source.is_settled_at(self._editing.frame) and not self._pull.is_alone:
            return now
        return self._pull.screen.shown() or now

    def update(self) -> None:
        """Answer a change of the shot with a picture that fits the time."""
        if self._pull.is_alone:
            return
        try:
            with faults_told("The picture could not be made"):
                self._scheduler.wish(
                    self._view.state, self._editing.shot, self._editing.frame, self._speed.budget_s
                )
        except HeatlensError as error:
            self._say_error(error)

    @property
    def is_working(self) -> bool:
        """There is a picture to go on with."""
        return not self._pull.is_alone and (self._scheduler.is_working or self._pull.has_work)

    def work(self) -> None:
        """Go on for a moment."""
        try:
            with faults_told("The picture could not be made"):
                if self._scheduler.is_working:
                    self._scheduler.work()
                else:
                    self._pull.work()
        except HeatlensError as error:
            self._say_error(error)

    @property
    def version(self) -> object:
        """Another one whenever there is something new to be seen."""
        return self._scheduler.version, self._pull.version

    def seconds_until_needed(self) -> float | None:
        """How long the loop may sleep; None: until something changes."""
        if self._pull.is_alone:
            return None
        if self._scheduler.is_working:
            return self._scheduler.seconds_until_needed()
        return self._pull.seconds_until_needed()
