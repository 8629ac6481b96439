"""Commands that choose the lens kit of the shot and the mounted lens of it."""

from dataclasses import replace

from heatlens.documents.lens_kits import KitShelf, kit_shelf
from heatlens.model.lens.lens_kit import KitLens, LensKit
from heatlens.session.loop.messages import Problem, reported
from heatlens.session.shared import Commands, Shared


class KitCommands(Commands):
    """Chooses kits and their lenses; each choice is one undo step."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self._shelf: KitShelf | None = None

    @property
    def shelf(self) -> KitShelf:
        """All lens kits, read at the first access; damaged files are reported."""
        if self._shelf is None:
            self._shelf = kit_shelf()
            if self._shelf.problems:
                self._say(Problem(self._shelf.problems[0]))
        return self._shelf

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all kits; the shot's kit is first if this machine does not have it."""
        kit = self._editing.shot.kit
        missing = () if kit is None or kit.name in self.shelf.kits else (kit.name,)
        return (*missing, *self.shelf.kits)

    @property
    def mounted(self) -> KitLens | None:
        """The mounted lens of the kit; None without a kit."""
        kit = self._editing.shot.kit
        return None if kit is None else kit.nearest(self._editing.lens.focal_length_mm)

    def choose(self, name: str | None) -> None:
        """Choose a kit by its name and mount its closest lens; None removes the kit."""
        kit = None if name is None else self.shelf.kits.get(name)
        if kit is None:
            if name is None:
                self._editing.do(replace(self._editing.shot, kit=None))
                self._say("The lens no longer belongs to a kit.")
            return
        self._mount(kit, kit.nearest(self._editing.lens.focal_length_mm))

    def breathe(self, is_on: bool) -> None:
        """Switch the breathing of the mounted lens on or off."""
        mounted, lens = self.mounted, self._editing.lens
        ratio = mounted.breathing if is_on and mounted is not None else 1.0
        self._editing.edit_lens(replace(lens, breathing=ratio))

    def mount(self, kit_lens: KitLens) -> None:
        """Mount another lens of the kit."""
        kit = self._editing.shot.kit
        if kit is not None:
            self._mount(kit, kit_lens)

    def _mount(self, kit: LensKit, kit_lens: KitLens) -> None:
        editing = self._editing
        with reported(self._say):
            lens = kit.mounted(editing.lens, kit_lens)
            editing.settle()
            editing.edit(replace(editing.shot, kit=kit))
            editing.edit_lens(lens)
            editing.settle()
            self._say(f"The lens is the {kit_lens.name} of {kit.name}: it {kit_lens.words}.")
