"""A focus that follows marks live. A thread measures the marks, and again when they change."""

from dataclasses import dataclass, replace

from heatlens.core.base.background import Background
from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.messages import Problem, Worker, report_errors
from heatlens.core.model.focus.live_focus import Follow, LiveFocus, Pursuit
from heatlens.core.model.marks.mark import Mark
from heatlens.core.model.shot.pull import bake_live_focus
from heatlens.core.model.shot.shot import Shot
from heatlens.render.source.live_focus import measure_followed_marks
from heatlens.studio.session.shared import Commands, Shared

_CHECK_S = 2.0  # between two checks of the files of plates


@dataclass(frozen=True)
class _Measurement:
    """A measured shot, and the key of everything that the measurement depends on."""

    key: object
    shot: Shot


class LiveFollowing(Commands, Worker):
    """Lets the focus follow marks live, and keeps it measured."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self._reader: Background[_Measurement] = Background(self._wake)
        self._measured_key: object = None  # the key of the last measurement, also of a failed one
        self._last_check_s = -_CHECK_S
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
        """Let the focus follow a mark at all frames, in place of its keys, and notify the user."""
        self._replace_keys(LiveFocus((Pursuit(mark.name),)))
        self._notify(f"The focus follows {mark.name}: it is measured at all frames.")

    def pull_to(self, mark: Mark, frames: int) -> None:
        """Leave the mark that is followed at the playhead for another one."""
        if self.live is not None:
            with report_errors(self._notify):
                self._replace_keys(self.live.add_pull(mark.name, self._editing.frame, frames))

    def change(self, follow: Follow) -> None:
        """Let the focus follow in another way; a drag becomes one step of undo."""
        shot, live = self._editing.shot, self.live
        if live is not None:
            curves = replace(shot.curves, live=replace(live, follow=follow))
            self._editing.edit(replace(shot, curves=curves))

    def make_keys(self) -> None:
        """Put keys in the place of the focus that follows."""
        self._do(bake_live_focus)

    def stop_following(self) -> None:
        """End the following; the focus stays as it is at the playhead."""
        shot = self._editing.shot
        with report_errors(self._notify):
            fixed_shot = replace(shot, lens=self._editing.lens)
            self._editing.do(replace(fixed_shot, curves=replace(shot.curves, live=None)))

    def _replace_keys(self, live: LiveFocus) -> None:
        """Let the focus follow marks, in place of its keys, as an undo step."""
        keyless = replace(self._editing.shot.curves.focus_distance_m, keys=())
        self._do(
            lambda shot: replace(
                shot, curves=replace(shot.curves, focus_distance_m=keyless, live=live)
            )
        )

    def poll(self) -> None:
        """Apply a finished measurement, and measure again if the marks or plates have changed."""
        try:
            measurement = self._reader.poll()
        except HeatlensError as error:
            self._has_failed = True
            self._notify(Problem(error))
            return
        if measurement is not None:
            self._apply_measurement(measurement)
        self._start_measuring()

    # Plates may be rendered again while the shot is open, so marks are measured again. That is no
    # act of the user, and makes no undo step. The shot may have changed since the thread began:
    # the result is used only where the key is the same, and how the focus follows stays as it is.
    def _apply_measurement(self, measurement: _Measurement) -> None:
        """Put the measured distances into the shot, without an undo step."""
        live = measurement.shot.curves.live

        def measured(shot: Shot) -> Shot:
            old_live = shot.curves.live
            if live is None or old_live is None or measurement.key != _measurement_key(shot):
                return shot
            new_live = replace(live, follow=old_live.follow)
            curves = replace(shot.curves, live=new_live)
            return shot if new_live == old_live else replace(shot, curves=curves)

        self._editing.amend(measured)

    def _start_measuring(self) -> None:
        """Start to measure on the thread if the marks or the plates may have changed."""
        shot = self._editing.shot
        if shot.curves.live is None or self._source.opened is None or self._reader.is_busy:
            return
        key = _measurement_key(shot)
        if key != self._measured_key or self.seconds_until_needed() == 0.0:
            self._measured_key = key
            self._has_failed = False
            self._last_check_s = self._editing.clock()
            self._reader.start(lambda: _Measurement(key, measure_followed_marks(shot)))

    def seconds_until_needed(self) -> float | None:
        """See `Worker`; plates may be rendered again at any time, and are then measured again."""
        opened = self._source.opened
        is_following_plates = (
            self.live is not None and opened is not None and opened.cache is not None
        )
        if not is_following_plates or self._has_failed or self._reader.is_busy:
            return None
        return max(0.0, self._last_check_s + _CHECK_S - self._editing.clock())


def _measurement_key(shot: Shot) -> object:
    """Return a key of everything in a shot that decides the distances of its marks."""
    live = shot.curves.live
    names = () if live is None else live.marks
    marks = tuple(mark for mark in shot.marks if mark.name in names)
    pursuits = None if live is None else live.pursuits
    return shot.source, shot.plate_options, shot.frames, shot.framing, marks, pursuits
