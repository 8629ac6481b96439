"""Define the requests that a front end makes with values: focus there, open that, show this frame.

Each is a value that can be built in Python or from a JSON object, see `board.py`. Another request
is another class here.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar, Literal

from heatlens.core.base.errors import InputError
from heatlens.core.model.view.orbit import CameraDrag
from heatlens.core.model.view.view import Compare
from heatlens.media.sequence.folder_walk import ChosenFile
from heatlens.studio.board.session import Session
from heatlens.studio.settings.export_settings import ExportSettings
from heatlens.studio.settings.file_purposes import PURPOSES


class Request(ABC):
    """A request to a session; pages in a browser may make those that are `is_remote`."""

    is_remote: ClassVar[bool] = True

    @abstractmethod
    def run(self, session: Session) -> None:
        """Do it. Raise HeatlensError with a sentence if it is impossible."""


@dataclass(frozen=True, slots=True)
class Open(Request):
    """Open a file, pattern, folder, scene or shot; the open source stays until it has arrived."""

    is_remote: ClassVar[bool] = False

    name: str

    def run(self, session: Session) -> None:
        session.files.commands.open(self.name)


@dataclass(frozen=True, slots=True)
class Save(Request):
    """Save the picture, the shot, or the pull sheet to a file."""

    is_remote: ClassVar[bool] = False

    path: str
    what: Literal["save", "save shot", "sheet"] = "save"

    def run(self, session: Session) -> None:
        files = session.files.commands
        if files.may_choose(self.what):
            files.apply_choice(ChosenFile(PURPOSES[self.what], Path(self.path).absolute()))


@dataclass(frozen=True, slots=True)
class Export(Request):
    """Begin to export frames as linear EXR; the session's message tells how that ended.

    folder  where they go; it is made if it is not there
    name    the part of their names before the number
    frames  those to export, such as "1001-1010"; "" for those from in to out
    """

    is_remote: ClassVar[bool] = False

    folder: str
    name: str
    frames: str = ""

    def run(self, session: Session) -> None:
        """Begin the export. Raises InputError if nothing is open, or one is running."""
        exports = session.files.exports
        why_not = exports.why_not or ("" if session.source.plate else "Nothing is open to export.")
        if exports.run.is_busy:
            why_not = "An export is running: begin another when it has finished."
        if why_not:
            raise InputError(why_not)
        exports.propose()
        folder, proposed = str(Path(self.folder).absolute()), exports.settings
        new = ExportSettings(folder=folder, name=self.name, frames=self.frames)
        exports.change(replace(new, is_single=proposed.is_single, place=proposed.place))
        exports.export()


@dataclass(frozen=True, slots=True)
class Go(Request):
    """Move the playhead to a frame."""

    frame: int

    def run(self, session: Session) -> None:
        session.time.timeline.go_to(self.frame)


@dataclass(frozen=True, slots=True)
class Focus(Request):
    """Set the focus distance, in meters."""

    distance_m: float

    def run(self, session: Session) -> None:
        session.lens.commands.focus(self.distance_m)


@dataclass(frozen=True, slots=True)
class NudgeFocus(Request):
    """Focus nearer by some notches of the focus bar, or farther if negative."""

    notches: float

    def run(self, session: Session) -> None:
        session.lens.commands.nudge_focus(self.notches)


@dataclass(frozen=True, slots=True)
class FocusAt(Request):
    """Focus on the object at a pixel of the picture, counted from its upper left corner."""

    x_px: int
    y_px: int

    def run(self, session: Session) -> None:
        """Change the focus of the lens at the playhead; do nothing outside the picture."""
        session.lens.commands.focus_at((self.x_px, self.y_px))


@dataclass(frozen=True, slots=True)
class MarkAt(Request):
    """Set a mark on the object at a pixel of the picture."""

    x_px: int
    y_px: int

    def run(self, session: Session) -> None:
        session.time.marks.set_point((self.x_px, self.y_px))


@dataclass(frozen=True, slots=True)
class Pull(Request):
    """Pull the focus from where it is to a mark, in a number of frames from the playhead on."""

    mark: str
    frames: int

    def run(self, session: Session) -> None:
        """Pull the focus to the mark. Raises InputError for an unknown mark or no frames."""
        marks = session.time.marks
        if session.editing.shot.mark_named(self.mark) is None:
            raise InputError(f"There is no mark {self.mark!r}.")
        if self.frames < 1:
            raise InputError(f"A pull must last at least 1 frame, not {self.frames}.")
        marks.pulls.suggest()
        marks.pulls.origin, marks.pulls.target = None, self.mark
        marks.pulls.set_length(self.frames)
        marks.pulls.make()


@dataclass(frozen=True, slots=True)
class TakeLook(Request):
    """Use the lens of a look, and leave the grid of looks."""

    name: str

    def run(self, session: Session) -> None:
        if self.name not in [look.name for look in session.editing.shot.looks]:
            raise InputError(f"There is no look {self.name!r}.")
        session.pictures.looks.use_named(self.name)
        if session.pictures.view.state.compare is Compare.GRID:
            session.pictures.commands.change(compare=Compare.OFF)


@dataclass(frozen=True, slots=True)
class MoveCamera(Request):
    """Orbit, truck or dolly the camera of a scene; see `CameraDrag`."""

    kind: Literal["orbit", "truck", "dolly"]
    right: float = 0.0
    down: float = 0.0

    def run(self, session: Session) -> None:
        """Move the camera; do nothing for a plate."""
        if session.source.has_camera:
            session.scenes.move(CameraDrag(self.kind, self.right, self.down))
