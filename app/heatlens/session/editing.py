"""The shot in hand: every change of it goes through here, so that every change can be undone."""

import time
from collections.abc import Callable
from dataclasses import replace

from heatlens.errors import HeatlensError, LensError
from heatlens.model.history import History
from heatlens.model.lens import Lens
from heatlens.model.shot import LensParameter, Shot
from heatlens.session.messages import Problem

_GESTURE_REST_S = 0.4  # notches of the wheel and repeated keys closer than this are one gesture


class Editing:
    """The history of the shot, and the frame that is edited."""

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
        """The shot as it is now."""
        return self.history.now

    @property
    def lens(self) -> Lens:
        """The lens at the frame.

        Where the keys ask for a lens that cannot be, that is said, and it is the lens without keys.
        """
        try:
            return self.shot.lens_at(self.frame)
        except LensError as error:
            self._say(Problem(error))
            return self.shot.lens

    @property
    def has_lens(self) -> bool:
        """Return True where the keys leave a lens at the frame."""
        try:
            self.shot.lens_at(self.frame)
        except LensError:
            return False
        return True

    def begin(self, shot: Shot) -> None:
        """Begin another shot, with nothing to undo."""
        self.history = History.of(shot)

    def edit(self, shot: Shot) -> None:
        """Change the shot; the step is made when the gesture ends."""
        if shot != self.history.now:
            self.history = self.history.changed(shot)
            self._changed_at = self._clock()

    def edit_lens(self, lens: Lens) -> None:
        """Change the lens at the frame; what has keys gets one there. Refusals are said."""
        if lens == self.lens:
            return
        try:
            self.edit(self._with_lens(lens))
        except HeatlensError as error:
            self._say(Problem(error))

    def _with_lens(self, lens: Lens) -> Shot:
        """Return the shot with this lens at the frame.

        What has no keys is set at once: two values may only go together, as a long lens and far
        focus do.
        """
        before, shot = self.lens, replace(self.shot, lens=lens)
        for parameter in LensParameter:
            value = getattr(lens, parameter)
            if shot.curves.of(parameter).keys and value != getattr(before, parameter):
                shot = shot.with_lens_value(self.frame, parameter, value, self.auto_key)
        return shot

    def do(self, shot: Shot) -> None:
        """Change the shot by a command: one step, whatever was done just before."""
        self.history = self.history.at_rest().changed(shot).at_rest()

    def settle(self) -> None:
        """Make a step of what was done so far; what comes now is another step."""
        self.history = self.history.at_rest()

    def rest(self, is_held: bool) -> None:
        """Make a step of a gesture that is over; call this once a frame."""
        if not is_held and self._clock() - self._changed_at > _GESTURE_REST_S:
            self.history = self.history.at_rest()

    @property
    def is_unsettled(self) -> bool:
        """Return True while a gesture waits to become a step."""
        return self.history.now != self.history.settled

    def toggle_auto_key(self) -> None:
        """Key what has keys wherever it is changed, or no more."""
        self.auto_key = not self.auto_key

    def undo(self) -> None:
        """Take one step back."""
        self.history = self.history.undone()

    def redo(self) -> None:
        """Take one step forward again."""
        self.history = self.history.redone()
