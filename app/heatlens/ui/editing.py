"""The shot in hand: every change of it goes through here, so that every change can be undone."""

import time
from collections.abc import Callable
from dataclasses import fields, replace

from heatlens.errors import HeatlensError
from heatlens.model.history import History
from heatlens.model.lens import Lens
from heatlens.model.shot import LensParameter, Shot

_GESTURE_REST_S = 0.4  # notches of the wheel and repeated keys closer than this are one gesture


class Editing:
    """A history and the frame that is edited."""

    def __init__(
        self, shot: Shot, say: Callable[[str], None], clock: Callable[[], float] = time.perf_counter
    ) -> None:
        self.history = History.of(shot)
        self.frame = 0
        self.auto_key = True
        self._say = say
        self._clock = clock
        self._changed_at = 0.0

    @property
    def shot(self) -> Shot:
        """The shot as it is seen."""
        return self.history.now

    @property
    def lens(self) -> Lens:
        """Its lens at the frame."""
        return self.shot.lens_at(self.frame)

    def begin(self, shot: Shot) -> None:
        """Another shot, with nothing to undo."""
        self.history = History.of(shot)

    def edit(self, shot: Shot) -> None:
        """Change the shot; the step is made when the gesture ends."""
        if shot != self.history.now:
            self.history = self.history.changed(shot)
            self._changed_at = self._clock()

    def edit_lens(self, lens: Lens) -> None:
        """Change the lens at the frame; what has keys gets one there. Refusals are said."""
        before = self.lens
        if lens == before:
            return
        shot = self.shot
        keyed = {str(parameter) for parameter in LensParameter}
        try:
            plain = {
                f.name: getattr(lens, f.name)
                for f in fields(lens)
                if f.name not in keyed and getattr(lens, f.name) != getattr(before, f.name)
            }
            shot = replace(shot, lens=replace(shot.lens, **plain)) if plain else shot
            for parameter in LensParameter:
                value = getattr(lens, parameter)
                if value != getattr(before, parameter):
                    shot = shot.with_lens_value(self.frame, parameter, value, self.auto_key)
        except HeatlensError as error:
            self._say(str(error))
            return
        self.edit(shot)

    def rest(self, is_held: bool) -> None:
        """Call once a frame: a gesture that is over becomes a step."""
        if not is_held and self._clock() - self._changed_at > _GESTURE_REST_S:
            self.history = self.history.at_rest()

    @property
    def is_unsettled(self) -> bool:
        """A gesture waits to become a step."""
        return self.history.now != self.history.settled

    def undo(self) -> None:
        """One step back."""
        self.history = self.history.undone()

    def redo(self) -> None:
        """One step forward."""
        self.history = self.history.redone()
