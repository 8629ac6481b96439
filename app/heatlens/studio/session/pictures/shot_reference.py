"""Another shot as side B: its lens, keys and blur on the frame that is open."""

from dataclasses import replace
from functools import partial
from pathlib import Path

from heatlens.core.base.background import Background
from heatlens.core.base.faults import report_faults
from heatlens.core.base.messages import Worker
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.picture_view import PictureView
from heatlens.core.model.view.view import Against, Compare
from heatlens.media.documents.shot_file import read_shot
from heatlens.studio.session.pictures.compare_sides import CompareSides
from heatlens.studio.session.shared import Commands, Shared


class ShotReference(Commands, Worker):
    """Reads another shot on a thread, and compares with it."""

    def __init__(self, shared: Shared, sides: CompareSides, view: PictureView) -> None:
        super().__init__(shared)
        self._sides, self._view = sides, view
        self._reader: Background[tuple[str, Shot]] = Background(self._wake)
        self.name = ""  # what the shot is called; "" before the first

    def open(self, path: Path, name: str = "") -> None:
        """Begin to read a shot file; `name` is what to call it if not by its file."""
        self._reader.start(partial(_read, path, name or path.name))

    def poll(self) -> None:
        """Compare with a shot that has been read. Raises InputError if it cannot be read."""
        result = self._reader.poll()
        if result is None:
            return
        self.name, shot = result
        self._sides.other_shot = shot
        state = self._view.state
        compare = Compare.WIPE if state.compare in (Compare.OFF, Compare.GRID) else state.compare
        self._view.state = replace(state, against=Against.SHOT, compare=compare, a_look="")
        self._notify(f"B is the shot of {self.name}.")


@report_faults("The shot could not be read")
def _read(path: Path, name: str) -> tuple[str, Shot]:
    """Return the name of a shot, and the shot. Raise InputError if it cannot be read."""
    return name, read_shot(path)
