"""Render the quickest preview once, unseen, before the first drag needs it.

Its programs are built from the driver's cache then, which takes half a second, and its time is
known, so that the first drag begins with the best level that fits.
"""

import time
from collections.abc import Callable
from dataclasses import replace

from heatlens.core.base.errors import HeatlensError
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.render.defocus.steps import Steps
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.known_programs import NewProgramError
from heatlens.render.gpu.program import programs_built
from heatlens.render.gpu.resources import Texture
from heatlens.render.preview.level_choice import useful_levels
from heatlens.render.preview.shown import ShownPicture
from heatlens.studio.session.pictures.live_picture import LivePicture

_MOST_TRIES = 3  # of a level: the first builds its programs, the second measures it


class Rehearsal:
    """Renders the quickest level of the shown picture in slices, until its time is known."""

    def __init__(
        self,
        renderer: FrameRenderer,
        live: LivePicture,
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        """Rehearse for `live` in the slot that it does not show."""
        self._renderer, self._live, self._clock = renderer, live, clock
        self.most_tries = _MOST_TRIES  # 0 to render nothing unseen
        self._tries: dict[DefocusSettings, int] = {}
        self._steps: Steps[Texture] | None = None
        self._begun_after = 0  # pictures that `live` had begun before
        self._programs_before, self._seconds = 0, 0.0

    @property
    def is_due(self) -> bool:
        """True if the whole picture is shown, and its quickest level was not timed yet."""
        picture = self._live.output
        if picture is None or not picture.is_whole or self._live.is_working:
            return False
        level = self._level(picture)
        return (
            level is not None
            and not self._live.cost.has_timed(level)
            and self._tries.get(level, 0) < self.most_tries
            and self._live.levels.is_buildable(level)
        )

    def _level(self, picture: ShownPicture) -> DefocusSettings | None:
        """Return the quickest level of a picture; None if it has no other than itself."""
        if picture.settings.method.needs_scene:
            return None
        size, has_many_views = self._renderer.loaded.color.size, self._renderer.has_many_views
        level = useful_levels(picture.settings, size, has_many_views)[-1]
        return None if level == picture.settings else level

    def work(self, slice_s: float) -> None:
        """Continue for a slice; a picture that `live` began in between makes it start again."""
        picture = self._live.output
        level = None if picture is None else self._level(picture)
        if picture is None or level is None:
            return
        if self._steps is None or self._begun_after != self._live.begun_count:
            self._begin(picture, level)
        start = self._clock()
        try:
            self._advance(picture, slice_s)
            self._seconds += self._clock() - start
        except StopIteration:
            self._renderer.ctx.finish()
            self._note_time(level, self._seconds + self._clock() - start)
        except NewProgramError:
            self._steps = None
            self._live.levels.note_refused(level)
            self._live.builder.request(picture.shot, picture.frame)
        except HeatlensError:  # whoever drags will be told
            self._steps, self._tries[level] = None, _MOST_TRIES

    def _begin(self, picture: ShownPicture, level: DefocusSettings) -> None:
        """Begin the picture of a level."""
        self._tries[level] = self._tries.get(level, 0) + 1
        self._begun_after, self._seconds = self._live.begun_count, 0.0
        self._programs_before = programs_built()
        shot = replace(picture.shot, defocus=level)
        self._steps = self._renderer.steps(
            shot, picture.frame, self._live.spare_slot, enlarges=True
        )

    def _advance(self, picture: ShownPicture, slice_s: float) -> None:
        """Render for a slice. Raises StopIteration at the end of the picture."""
        assert self._steps is not None
        start = self._clock()
        with self._live.builder.refuse_new(picture.shot):
            while self._clock() - start < slice_s:
                next(self._steps)

    def _note_time(self, level: DefocusSettings, seconds: float) -> None:
        """Let the cost model learn the time of a finished picture."""
        has_built = programs_built() > self._programs_before
        self._live.cost.learn(level, self._live.levels.pixel_count(level), seconds, has_built)
        self._live.levels.note_rendered(level)
        self._steps = None
