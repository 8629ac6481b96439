"""Keep the current lens as a look, return to looks, and compare with them."""

import base64
import binascii
from collections.abc import Callable
from dataclasses import replace
from io import BytesIO

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.mark import free_letter
from heatlens.core.model.shot.look import Look
from heatlens.core.model.view.view import GRID_MOST, Against, Compare, ViewState
from heatlens.media.files.opened_by_ending import picture_of
from heatlens.studio.session.messages import Problem, reported
from heatlens.studio.session.pictures.picture_view import PictureView
from heatlens.studio.session.shared import Commands, Shared

KEYED = 9  # looks with a shortcut


class LookCommands(Commands):
    """The commands on looks; each change of the shot is one undo step."""

    def __init__(self, shared: Shared, view: PictureView) -> None:
        super().__init__(shared)
        self._view = view
        self._before: Lens | None = None  # the lens before the latest look was used
        self.still_now: Callable[[], str | None] = lambda: None  # returns a still of the picture

    @property
    def looks(self) -> tuple[Look, ...]:
        """The looks of the shot."""
        return self._editing.shot.looks

    def keep(self) -> None:
        """Keep the lens at the playhead as a look, named with the next free letter."""
        shot = self._editing.shot
        name, frame = free_letter(look.name for look in shot.looks), self._editing.frame
        look = Look(name, self._editing.lens, frame, self.still_now())
        self._editing.do(replace(shot, looks=(*shot.looks, look)))
        key = f" Ctrl+{len(self.looks)} returns to it." if len(self.looks) <= KEYED else ""
        self._say(f"Look {look.name} is kept.{key}")

    def go(self, index: int) -> None:
        """Use the lens of a look; keyed parameters get a key at the playhead."""
        if index >= len(self.looks):
            self._say(Problem(f"There are {len(self.looks)} looks. Shift+L keeps one."))
            return
        self._take(self.looks[index].lens)

    def go_to(self, name: str) -> None:
        """Use the lens of the look with this name."""
        names = [look.name for look in self.looks]
        if name in names:
            self.go(names.index(name))

    def back(self) -> None:
        """Return to the lens before the latest look; a second call returns to the look."""
        if self._before is None:
            self._say(Problem("There is no earlier lens: no look has been applied yet."))
        else:
            self._take(self._before)

    def _take(self, lens: Lens) -> None:
        """Change to a lens as one undo step, and remember the previous one."""
        before = self._editing.lens
        self._editing.choose_lens(lens)
        if before != lens:
            self._before = before

    def rename(self, look: Look, name: str) -> None:
        """Rename a look."""
        with reported(self._say):
            self._replace(look, (replace(look, name=name.strip()),))

    def delete(self, look: Look) -> None:
        """Delete a look."""
        self._replace(look, ())

    def _replace(self, look: Look, by: tuple[Look, ...]) -> None:
        shot = self._editing.shot
        at = shot.looks.index(look)
        self._editing.do(replace(shot, looks=(*shot.looks[:at], *by, *shot.looks[at + 1 :])))

    def compare(self, look: Look) -> None:
        """Make B the frame through the look; show it with the wipe unless a comparison is on."""
        state = self._compared()
        a_look = "" if state.a_look == look.name else state.a_look
        self._view.state = replace(state, b_look=look.name, a_look=a_look)

    def compare_as_a(self, look: Look) -> None:
        """Make A the frame through the look, or through the current lens if A is this look already.

        B stays a different look, or becomes the first other one.
        """
        state = self._compared()
        others = [other.name for other in self.looks if other != look]
        if state.a_look == look.name or not others:
            if not others:
                self._say(Problem("A second look is needed on the right. Shift+L keeps one."))
            self._view.state = replace(self._view.state, a_look="")
            return
        b_look = state.b_look if state.b_look in others else others[0]
        self._view.state = replace(state, a_look=look.name, b_look=b_look)

    def _compared(self) -> ViewState:
        """Return the view comparing looks, with the wipe unless another comparison is on."""
        state = self._view.state
        is_beside = state.compare in (Compare.OFF, Compare.GRID)
        compare = Compare.WIPE if is_beside else state.compare
        was_look = state.against is Against.LOOK and not is_beside
        a_look = state.a_look if was_look else ""
        return replace(state, against=Against.LOOK, compare=compare, a_look=a_look)

    def toggle_grid(self) -> None:
        """Switch between a grid of up to four looks and the single picture."""
        is_on = self._view.state.compare is Compare.GRID
        if not is_on and not self.looks:
            self._say(Problem("There are no looks yet. Shift+L keeps the lens as one."))
            return
        compare = Compare.OFF if is_on else Compare.GRID
        self._view.state = replace(self._view.state, compare=compare)

    def toggle_in_grid(self, look: Look) -> None:
        """Add a look to the grid or remove it; a fifth one replaces the first."""
        names = [other.name for other in self.looks]
        chosen = [n for n in names if n in self._view.state.grid] or names[:GRID_MOST]
        if look.name in chosen:
            chosen.remove(look.name)
        else:
            chosen = [*chosen[-GRID_MOST + 1 :], look.name]
        self._view.state = replace(self._view.state, grid=tuple(chosen))


_QUALITY = 85
_SIDE_MOST = 1024  # pixels; larger pictures are rejected


def still_of(pixels: NDArray[np.uint8]) -> str:
    """Return a picture, (H, W, 3), as the text of a still."""
    file = BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels)).save(file, "JPEG", quality=_QUALITY)
    return base64.b64encode(file.getvalue()).decode("ascii")


def pixels_of_still(text: str) -> NDArray[np.uint8] | None:
    """Return the picture of a still, (H, W, 3); None for an invalid text."""
    try:
        data = base64.b64decode(text, validate=True)
        with picture_of(data, ("JPEG",)) as image:
            if max(image.size) > _SIDE_MOST:
                return None
            return np.asarray(image.convert("RGB"), np.uint8)
    except (binascii.Error, OSError, ValueError, Image.DecompressionBombError):
        return None
