"""The commands on keys; each is one undo step, and reports why it is impossible if so."""

from collections.abc import Callable

from heatlens.core.base.messages import report_errors
from heatlens.core.model.curves.interpolation import Interpolation
from heatlens.core.model.keys import key_choice
from heatlens.core.model.keys.key_choice import CopiedKeys, KeySelection, all_keys
from heatlens.core.model.keys.key_rows import CAMERA, Row, RowChoice, key_count
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.studio.session.shared import Commands, Shared


class KeyCommands(Commands):
    """Keeps the selection and the copied keys, and runs the commands on them."""

    def __init__(self, shared: Shared, rows: RowChoice, set_camera_key: Callable[[], None]) -> None:
        super().__init__(shared)
        self.rows = rows
        self._set_camera_key = set_camera_key
        self._selection: KeySelection = frozenset()
        self._copied_keys: CopiedKeys = ()

    @property
    def selection(self) -> KeySelection:
        """The chosen keys that still exist."""
        return self._selection & all_keys(self._editing.shot)

    def select(self, keys: KeySelection) -> None:
        """Select these keys and no others."""
        self._selection = keys

    def select_between(self, row: Row, first: float, last: float) -> None:
        """Select the keys of a row from the first to the last frame."""
        keys = all_keys(self._editing.shot)
        self._selection = frozenset(k for k in keys if k.row is row and first <= k.frame <= last)

    def select_all(self) -> None:
        """Select every key of every row."""
        self._selection = all_keys(self._editing.shot)

    @property
    def target_keys(self) -> KeySelection:
        """The keys that commands act on: the chosen ones, or those at the playhead if none are."""
        return self.selection or key_choice.keys_at(self._editing.shot, self._editing.frame)

    def set_here(self) -> None:
        """Set keys at the playhead, for the camera if its row is selected, else for the lens.

        For the lens, the focus and every parameter with keys get one.
        """
        if self.rows.selected_row is CAMERA:
            self._set_camera_key()
            return
        frame = self._editing.frame
        self._editing.settle()
        self._editing.key_trial_values()
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
        self._do(lambda shot: key_choice.delete_keys(shot, self.target_keys, frame))

    def copy(self) -> None:
        """Copy the keys for `paste`, and notify the user."""
        if self.target_keys:
            self._copied_keys = key_choice.copy_keys(self._editing.shot, self.target_keys)
            self._notify(f"{_count_words(len(self.target_keys))} copied.")

    def paste(self) -> None:
        """Paste the copied keys from the playhead on, and notify the user."""
        if not self._copied_keys:
            self._notify("No keys were copied.")
            return
        self._do_and_select(
            lambda shot: key_choice.paste_keys(shot, self._copied_keys, self._editing.frame)
        )

    def move(self, by_frames: float) -> None:
        """Move the keys by a number of frames; a negative number moves them earlier."""
        if by_frames:
            old_shot = self._editing.shot
            self._do_and_select(
                lambda shot: key_choice.move_keys(shot, self.target_keys, by_frames)
            )
            self.report_replaced_keys(old_shot)

    def report_replaced_keys(self, old_shot: Shot) -> None:
        """Report how many keys of `old_shot` were removed because others were moved onto them."""
        removed_count = key_count(old_shot) - key_count(self._editing.shot)
        if removed_count > 0:
            self._notify(
                f"{_count_words(removed_count)} gave way to the moved keys. Ctrl+Z undoes it."
            )

    def interpolate(self, interpolation: Interpolation) -> None:
        """Set the interpolation after each of the keys."""
        self._do(lambda shot: key_choice.interpolate_keys(shot, self.target_keys, interpolation))

    def ease(self, influence_percent: float, is_out: bool) -> None:
        """Set the ease out or in of the keys; dragging the number is one undo step."""
        with report_errors(self._notify):
            self._editing.edit(
                key_choice.ease_keys(
                    self._editing.shot, self.target_keys, influence_percent, is_out
                )
            )

    def _do_and_select(self, change: Callable[[Shot], tuple[Shot, KeySelection]]) -> None:
        """Change the shot as an undo step, and select the keys that `change` returns with it."""
        with report_errors(self._notify):
            shot, selection = change(self._editing.shot)
            self._editing.do(shot)
            self._selection = selection


def _count_words(keys: int) -> str:
    return "One key" if keys == 1 else f"{keys} keys"
