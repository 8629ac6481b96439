"""Tells once of each source that surfaces behind its picture were merged or left out."""

from collections.abc import Callable

from heatlens.plate.plate import Plate


class LostSurfaces:
    """Looks at the pictures as they come."""

    def __init__(self, say: Callable[[str], None]) -> None:
        """Take `say`, which shows a sentence in the status bar."""
        self._say = say
        self._noted: tuple[str, ...] = ()
        self._is_told = False

    def begin(self, notes: tuple[str, ...]) -> None:
        """Begin with another source, of which `notes` have been said."""
        self._noted = notes
        self._is_told = False

    def look(self, plate: Plate | None) -> None:
        """Say the sentence of the first picture that has one."""
        if self._is_told or plate is None or not plate.surfaces_lost:
            return
        self._is_told = True
        if plate.surfaces_lost not in self._noted:
            self._say(plate.surfaces_lost)
