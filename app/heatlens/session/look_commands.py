"""Keep the lens of the moment as a look, come back to it, and compare with it."""

from collections.abc import Callable
from dataclasses import replace

from heatlens.errors import HeatlensError
from heatlens.model.look import Look, next_look_name
from heatlens.model.view import Against, Compare
from heatlens.session.editing import Editing
from heatlens.session.messages import Problem
from heatlens.session.picture_view import PictureView

KEYED = 9  # looks that have a key of their own


class LookCommands:
    """What can be done with looks; each change of the shot can be undone."""

    def __init__(self, editing: Editing, view: PictureView, say: Callable[[str], None]) -> None:
        self._editing = editing
        self._view = view
        self._say = say

    @property
    def looks(self) -> tuple[Look, ...]:
        """Those of the shot."""
        return self._editing.shot.looks

    def keep(self) -> None:
        """Keep the lens at the playhead under the next free letter."""
        shot = self._editing.shot
        look = Look(next_look_name(shot.looks), self._editing.lens, self._editing.frame)
        self._editing.do(replace(shot, looks=(*shot.looks, look)))
        key = f" Ctrl+{len(self.looks)} comes back to it." if len(self.looks) <= KEYED else ""
        self._say(f"Look {look.name} is kept.{key}")

    def go(self, index: int) -> None:
        """Take the lens of a look again; what has keys gets one at the playhead."""
        if index >= len(self.looks):
            self._say(Problem(f"There are {len(self.looks)} looks. Shift+L keeps one."))
            return
        self._editing.settle()
        self._editing.edit_lens(self.looks[index].lens)
        self._editing.settle()

    def rename(self, look: Look, name: str) -> None:
        """Call a look by another name."""
        try:
            self._replace(look, (replace(look, name=name.strip()),))
        except HeatlensError as error:
            self._say(Problem(error))

    def delete(self, look: Look) -> None:
        """Forget a look."""
        self._replace(look, ())

    def _replace(self, look: Look, by: tuple[Look, ...]) -> None:
        shot = self._editing.shot
        at = shot.looks.index(look)
        self._editing.do(replace(shot, looks=(*shot.looks[:at], *by, *shot.looks[at + 1 :])))

    def compare(self, look: Look) -> None:
        """Have B be the frame through the look, under the wipe unless it is compared already."""
        state = self._view.state
        compare = Compare.WIPE if state.compare is Compare.OFF else state.compare
        self._view.state = replace(state, against=Against.LOOK, b_look=look.name, compare=compare)
