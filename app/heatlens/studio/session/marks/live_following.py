"""A focus that follows marks live: measured on a thread, again when plates or marks change."""

from dataclasses import dataclass, replace

from heatlens.core.base.background import Background
from heatlens.core.base.errors import HeatlensError
from heatlens.core.model.focus.live_focus import Follow, LiveFocus, Pursuit
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.shot.pull import baked
from heatlens.core.model.shot.shot import Shot
from heatlens.render.source.live_focus import measured
from heatlens.studio.session.messages import Problem, Worker, reported
from heatlens.studio.session.shared import Commands, Shared

_LOOK_S = 2.0  # between two looks at the files of plates


@dataclass(frozen=True)
class _Found:
    """A shot as it was measured, and what of the shot that depended on."""

    asked: object
    shot: Shot


class LiveFollowing(Commands, Worker):
    """Lets the focus follow marks live, and keeps it measured."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self._reader: Background[_Found] = Background(self._wake)
        self._known: object = None  # what was measured last, or could not be
        self._looked_at = -_LOOK_S
        self._has_failed = False

    @property
    def live(self) -> LiveFocus | None:
        """How the focus follows; None where it has a value or keys."""
        return self._editing.shot.curves.live

    @property
    def is_measuring(self) -> bool:
        """True while marks are measured for the first time, or again."""
        return self._reader.is_busy

    def follow(self, mark: Mark) -> None:
        """Let the focus follow a mark at all frames, in place of its keys."""
        self._set(LiveFocus((Pursuit(mark.name),)))
        self._say(f"The focus follows {mark.name}: it is measured at all frames.")

    def pull_to(self, mark: Mark, frames: int) -> None:
        """Leave the mark that is followed at the playhead for another one."""
        if self.live is not None:
            with reported(self._say):
                self._set(self.live.pulled_to(mark.name, self._editing.frame, frames))

    def change(self, follow: Follow) -> None:
        """Let the focus follow in another way; a drag becomes one step of undo."""
        shot, live = self._editing.shot, self.live
        if live is not None:
            curves = replace(shot.curves, live=replace(live, follow=follow))
            self._editing.edit(replace(shot, curves=curves))

    def make_keys(self) -> None:
        """Put keys in the place of the focus that follows."""
        self._do(baked)

    def let_go(self) -> None:
        """End the following; the focus stays as it is at the playhead."""
        shot = self._editing.shot
        with reported(self._say):
            still = replace(shot, lens=self._editing.lens)
            self._editing.do(replace(still, curves=replace(shot.curves, live=None)))

    def _set(self, live: LiveFocus) -> None:
        keyless = replace(self._editing.shot.curves.focus_distance_m, keys=())
        self._do(
            lambda shot: replace(
                shot, curves=replace(shot.curves, focus_distance_m=keyless, live=live)
            )
        )

    def poll(self) -> None:
        """Take over what was measured, and look whether it has changed."""
        try:
            measurement = self._reader.poll()
        except HeatlensError as error:
            self._has_failed = True
            self._say(Problem(error))
            return
        if measurement is not None:
            self._take(measurement)
        self._look()

    # Plates may be rendered again while the shot lies open, so what follows is measured again, too.
    # That is no act of the user, and makes no step of undo. The shot may have changed since the
    # thread began: its result is used only if what it depends on is the same, and how the focus
    # follows is taken from the shot of now.
    def _take(self, measurement: _Found) -> None:
        """Put the distances into the shot, without a step of undo; it may have changed since."""
        live, now = measurement.shot.curves.live, self._editing.shot
        if live is None or now.curves.live is None or measurement.asked != _depends(now):
            return
        live = replace(live, follow=now.curves.live.follow)
        if live != now.curves.live:
            self._editing.amend(replace(now, curves=replace(now.curves, live=live)))

    def _look(self) -> None:
        shot = self._editing.shot
        if shot.curves.live is None or self._source.opened is None or self._reader.is_busy:
            return
        depends = _depends(shot)
        if depends != self._known or self.seconds_until_needed() == 0.0:
            self._known, self._has_failed, self._looked_at = depends, False, self._editing.clock()
            self._reader.start(lambda: _Found(depends, measured(shot)))

    def seconds_until_needed(self) -> float | None:
        """See `Worker`; plates may be rendered again at any time, and are then measured again."""
        opened = self._source.opened
        is_asked = self.live is not None and opened is not None and opened.cache is not None
        if not is_asked or self._has_failed or self._reader.is_busy:
            return None
        return max(0.0, self._looked_at + _LOOK_S - self._editing.clock())


def _depends(shot: Shot) -> object:
    """Return what of a shot decides the distances of its marks."""
    live = shot.curves.live
    names = () if live is None else live.marks
    marks = tuple(mark for mark in shot.marks if mark.name in names)
    pursuits = None if live is None else live.pursuits
    return shot.source, shot.plate_options, shot.frames, shot.framing, marks, pursuits
