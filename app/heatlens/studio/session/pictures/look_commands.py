"""Keep the current lens as a look, return to looks, and compare with them."""

from dataclasses import replace

from heatlens.core.base.messages import Problem, report_errors
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.mark import free_letter
from heatlens.core.model.shot.look import Look
from heatlens.core.model.view.picture_view import PictureView
from heatlens.core.model.view.view import GRID_MOST, Against, Compare, ViewState
from heatlens.studio.session.shared import Commands, Shared

LOOKS_WITH_KEY = 9  # looks with a shortcut


class LookCommands(Commands):
    """The commands on looks; each change of the shot is one undo step."""

    def __init__(self, shared: Shared, view: PictureView) -> None:
        super().__init__(shared)
        self._view = view
        self._previous_lens: Lens | None = None  # the lens before the latest look was used

    @property
    def looks(self) -> tuple[Look, ...]:
        """The looks that the shot keeps, in order."""
        return self._editing.shot.looks

    def keep(self, still: str | None = None) -> None:
        """Keep the lens at the playhead as a look, named with the next free letter.

        `still` is the present picture, see `still_of`; None if there is none to keep.
        """
        shot = self._editing.shot
        name, frame = free_letter(look.name for look in shot.looks), self._editing.frame
        look = Look(name, self._editing.lens, frame, still)
        self._editing.do(replace(shot, looks=(*shot.looks, look)))
        key = f" Ctrl+{len(self.looks)} returns to it." if len(self.looks) <= LOOKS_WITH_KEY else ""
        self._notify(f"Look {look.name} is kept.{key}")

    def use_number(self, index: int) -> None:
        """Use the lens of a look; keyed parameters get a key at the playhead. Notifies the user."""
        if index >= len(self.looks):
            self._notify(Problem(f"There are {len(self.looks)} looks. Shift+L keeps one."))
            return
        self._use_lens(self.looks[index].lens)

    def use_named(self, name: str) -> None:
        """Use the lens of the look with this name."""
        names = [look.name for look in self.looks]
        if name in names:
            self.use_number(names.index(name))

    def use_previous_lens(self) -> None:
        """Return to the lens before the latest look; a second call returns to the look."""
        if self._previous_lens is None:
            self._notify(Problem("There is no earlier lens: no look has been applied yet."))
        else:
            self._use_lens(self._previous_lens)

    def _use_lens(self, lens: Lens) -> None:
        """Change to a lens as one undo step, and remember the previous one."""
        old_lens = self._editing.lens
        self._editing.choose_lens(lens)
        if old_lens != lens:
            self._previous_lens = old_lens

    def rename(self, look: Look, name: str) -> None:
        """Give a look another name, as one undo step."""
        with report_errors(self._notify):
            self._replace_look(look, (replace(look, name=name.strip()),))

    def delete(self, look: Look) -> None:
        """Delete a look from the shot, as one undo step."""
        self._replace_look(look, ())

    def _replace_look(self, look: Look, new_looks: tuple[Look, ...]) -> None:
        """Replace a look of the shot by one or none, as an undo step."""
        shot = self._editing.shot
        index = shot.looks.index(look)
        self._editing.do(
            replace(shot, looks=(*shot.looks[:index], *new_looks, *shot.looks[index + 1 :]))
        )

    def compare(self, look: Look) -> None:
        """Make B the frame through the look; show it with the wipe unless a comparison is on."""
        state = self._look_comparison()
        a_look = "" if state.a_look == look.name else state.a_look
        self._view.state = replace(state, b_look=look.name, a_look=a_look)

    def compare_as_a(self, look: Look) -> None:
        """Make A the frame through the look, or through the current lens if A is this look already.

        B stays a different look, or becomes the first other one. Notifies the user.
        """
        state = self._look_comparison()
        other_names = [other_look.name for other_look in self.looks if other_look != look]
        if state.a_look == look.name or not other_names:
            if not other_names:
                self._notify(Problem("A second look is needed on the right. Shift+L keeps one."))
            self._view.state = replace(self._view.state, a_look="")
            return
        b_look = state.b_look if state.b_look in other_names else other_names[0]
        self._view.state = replace(state, a_look=look.name, b_look=b_look)

    def _look_comparison(self) -> ViewState:
        """Return the view comparing looks, with the wipe unless another comparison is on."""
        state = self._view.state
        is_no_comparison = state.compare in (Compare.OFF, Compare.GRID)
        compare = Compare.WIPE if is_no_comparison else state.compare
        was_of_looks = state.against is Against.LOOK and not is_no_comparison
        a_look = state.a_look if was_of_looks else ""
        return replace(state, against=Against.LOOK, compare=compare, a_look=a_look)

    def toggle_grid(self) -> None:
        """Switch between a grid of up to four looks and the single picture, and notify the user."""
        is_on = self._view.state.compare is Compare.GRID
        if not is_on and not self.looks:
            self._notify(Problem("There are no looks yet. Shift+L keeps the lens as one."))
            return
        compare = Compare.OFF if is_on else Compare.GRID
        self._view.state = replace(self._view.state, compare=compare)

    def toggle_in_grid(self, look: Look) -> None:
        """Add a look to the grid or remove it; a fifth one replaces the first."""
        names = [shot_look.name for shot_look in self.looks]
        grid = [name for name in names if name in self._view.state.grid] or names[:GRID_MOST]
        if look.name in grid:
            grid.remove(look.name)
        else:
            grid = [*grid[-GRID_MOST + 1 :], look.name]
        self._view.state = replace(self._view.state, grid=tuple(grid))
