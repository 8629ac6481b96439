"""Report once per source that surfaces behind its picture were merged or left out."""

from heatlens.session.loop.worker import Worker
from heatlens.session.shared import Commands, Shared


class LostSurfaces(Commands, Worker):
    """Watches the pictures of a source for notes about lost surfaces."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self._noted: tuple[str, ...] = ()
        self._is_reported = False

    def begin(self, notes: tuple[str, ...]) -> None:
        """Begin with another source; `notes` have been reported already."""
        self._noted = notes
        self._is_reported = False

    def poll(self) -> None:
        """Report the note of the first picture that has one."""
        plate = self._source.plate
        if self._is_reported or plate is None or not plate.surfaces_lost:
            return
        self._is_reported = True
        if plate.surfaces_lost not in self._noted:
            self._say(plate.surfaces_lost)
