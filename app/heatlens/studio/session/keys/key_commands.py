"""The commands on keys; each is one undo step, and reports why it is impossible if so."""

from collections.abc import Callable

from heatlens.core.model.curves.interpolation import Interpolation
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.studio.session.keys import key_choice
from heatlens.studio.session.keys.key_choice import Chosen, Copied, all_keys
from heatlens.studio.session.keys.key_rows import CAMERA, Row, RowChoice, key_count
from heatlens.studio.session.messages import reported
from heatlens.studio.session.shared import Commands, Shared


class KeyCommands(Commands):
    """Keeps the selection and the copied keys, and runs the commands on them."""

    def __init__(self, shared: Shared, rows: RowChoice, set_camera_key: Callable[[], None]) -> None:
        super().__init__(shared)
        self.rows = rows
        self._set_camera_key = set_camera_key
        self._chosen: Chosen = frozenset()
        self._copied: Copied = ()

    @property
    def chosen(self) -> Chosen:
        """The chosen keys that still exist."""
        return self._chosen & all_keys(self._editing.shot)

    def choose(self, keys: Chosen) -> None:
        """Select these keys and no others."""
        self._chosen = keys

    def choose_between(self, row: Row, first: float, last: float) -> None:
        """Select the keys of a row from the first to the last frame."""
        keys = all_keys(self._editing.shot)
        self._chosen = frozenset(k for k in keys if k.row is row and first <= k.frame <= last)

    def choose_all(self) -> None:
        """Select every key of every row."""
        self._chosen = all_keys(self._editing.shot)

    @property
    def meant(self) -> Chosen:
        """The keys that commands act on: the chosen ones, or those at the playhead if none are."""
        return self.chosen or key_choice.keys_at(self._editing.shot, self._editing.frame)

    def set_here(self) -> None:
        """Set keys at the playhead, for the camera if its row is selected, else for the lens.

        For the lens, the focus and every parameter with keys get one.
        """
        if self.rows.chosen is CAMERA:
            self._set_camera_key()
            return
        frame = self._editing.frame
        self._editing.settle()
        self._editing.keep_tried()
        self._do(lambda shot: key_choice.with_keys_here(shot, frame))

    def toggle_here(self, parameter: LensParameter) -> None:
        """Set a key of one parameter at the playhead, or remove the one that is there."""
        shot, frame = self._editing.shot, self._editing.frame
        if shot.curves.of(parameter).key_at(frame) is None:
            self._do(lambda shot: shot.with_key(frame, parameter))
        else:
            self._do(lambda shot: shot.without_key(frame, parameter))

    def delete(self) -> None:
        """Delete the chosen keys, or those at the playhead."""
        frame = self._editing.frame
        self._do(lambda shot: key_choice.deleted(shot, self.meant, frame))

    def copy(self) -> None:
        """Copy the keys for `paste`."""
        if self.meant:
            self._copied = key_choice.copied(self._editing.shot, self.meant)
            self._say(f"{_count(len(self.meant))} copied.")

    def paste(self) -> None:
        """Paste the copied keys from the playhead on."""
        if not self._copied:
            self._say("No keys were copied.")
            return
        self._do_and_choose(lambda shot: key_choice.pasted(shot, self._copied, self._editing.frame))

    def move(self, by_frames: float) -> None:
        """Move the keys by a number of frames; a negative number moves them earlier."""
        if by_frames:
            before = self._editing.shot
            self._do_and_choose(lambda shot: key_choice.moved(shot, self.meant, by_frames))
            self.tell_of_replaced(before)

    def tell_of_replaced(self, before: Shot) -> None:
        """Report how many keys were removed since `before` because others were moved onto them."""
        gone = key_count(before) - key_count(self._editing.shot)
        if gone > 0:
            self._say(f"{_count(gone)} gave way to the moved keys. Ctrl+Z undoes it.")

    def interpolate(self, interpolation: Interpolation) -> None:
        """Set the interpolation after each of the keys."""
        self._do(lambda shot: key_choice.interpolated(shot, self.meant, interpolation))

    def ease(self, influence_percent: float, is_out: bool) -> None:
        """Set the ease out or in of the keys; dragging the number is one undo step."""
        with reported(self._say):
            self._editing.edit(
                key_choice.eased(self._editing.shot, self.meant, influence_percent, is_out)
            )

    def _do_and_choose(self, change: Callable[[Shot], tuple[Shot, Chosen]]) -> None:
        with reported(self._say):
            shot, chosen = change(self._editing.shot)
            self._editing.do(shot)
            self._chosen = chosen


def _count(keys: int) -> str:
    return "One key" if keys == 1 else f"{keys} keys"
