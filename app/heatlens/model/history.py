"""Undo: the shots that were, one step for each gesture."""

from dataclasses import dataclass, replace

from heatlens.model.shot import Shot
from heatlens.model.shot_change import change_words

_STEPS_MAX = 1000


@dataclass(frozen=True, slots=True)
class History:
    """Steps before `now`, and those undone. `now` may be ahead of its last step: a drag goes on.

    past      shots that undo goes back to, the latest last
    settled   the shot at the end of the last gesture
    now       what is seen
    future    shots that redo goes forward to, the next one last
    """

    past: tuple[Shot, ...]
    settled: Shot
    now: Shot
    future: tuple[Shot, ...] = ()

    @classmethod
    def of(cls, shot: Shot) -> "History":
        """Return a new history of a shot."""
        return cls((), shot, shot)

    @property
    def undo_words(self) -> str:
        """What undo would change, in a few words; "" if there is nothing to undo."""
        rest = self.at_rest()
        return change_words(rest.past[-1], rest.now) if rest.past else ""

    @property
    def redo_words(self) -> str:
        """What redo would change, in a few words; "" if there is nothing to redo."""
        rest = self.at_rest()
        return change_words(rest.now, rest.future[-1]) if rest.future else ""

    def changed(self, shot: Shot) -> "History":
        """Show `shot` now; its step is made when the gesture ends."""
        return self if shot == self.now else replace(self, now=shot)

    def at_rest(self) -> "History":
        """End the gesture: what it changed becomes one step."""
        if self.now == self.settled:
            return self
        past = (*self.past, self.settled)[-_STEPS_MAX:]
        return History(past, self.now, self.now)

    def undone(self) -> "History":
        """Go one step back; a gesture under way is ended first."""
        rest = self.at_rest()
        if not rest.past:
            return rest
        before = rest.past[-1]
        return History(rest.past[:-1], before, before, (*rest.future, rest.now))

    def redone(self) -> "History":
        """Go one step forward again."""
        rest = self.at_rest()
        if not rest.future:
            return rest
        after = rest.future[-1]
        return History((*rest.past, rest.now), after, after, rest.future[:-1])
