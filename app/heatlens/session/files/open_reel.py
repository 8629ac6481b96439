"""The reel of the session: a cut of which one shot is open, and the way to the others."""

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from heatlens.base.background import Background
from heatlens.base.errors import HeatlensError, InputError
from heatlens.documents.edit_read import EditOptions
from heatlens.documents.reel_file import is_reel, read_reel
from heatlens.documents.shot_file import is_shot_file, read_shot
from heatlens.model.reel import Reel, ReelShot
from heatlens.model.shot import Shot
from heatlens.session.files.shot_documents import ShotDocuments
from heatlens.session.loop.worker import Worker
from heatlens.session.shared import Commands, Shared


@dataclass(frozen=True)
class CutFocus:
    """The focus of a shot where the cut begins and ends, in m; None if it is not known."""

    first_m: float | None = None
    last_m: float | None = None


@dataclass(frozen=True)
class _Read:
    path: Path
    reel: Reel
    focus: tuple[CutFocus, ...]


class OpenReel(Commands, Worker):
    """Opens a reel or an edit, and one of its shots after the other.

    Going to another shot saves the one that is left if it has a file.
    """

    def __init__(self, shared: Shared, documents: ShotDocuments) -> None:
        super().__init__(shared)
        self._documents = documents
        self._reader: Background[_Read] = Background(self._wake)
        self.path: Path | None = None
        self.reel: Reel | None = None
        self.focus: tuple[CutFocus, ...] = ()  # of each shot, as read or as last left
        self.at = 0  # the number of the open shot
        self._wanted: ReelShot | None = None  # its plates are on their way

    def opens(self, text: str) -> bool:
        """Begin to open `text` if it is a reel or an edit, and return whether it is one."""
        if is_reel(text):
            self._reader.start(partial(_read, Path(text).expanduser().absolute()))
        return is_reel(text)

    @property
    def why_not(self) -> str:
        """Why there is no other shot to go to; "" if there is one."""
        return "" if self.reel is not None else "No reel and no edit is open."

    def step(self, by: int) -> None:
        """Go to the next shot or the one before, past those whose media are missing."""
        if self.reel is None:
            return
        at = self.at + by
        while 0 <= at < len(self.reel.shots) and not self.reel.shots[at].source:
            at += by
        if 0 <= at < len(self.reel.shots):
            self.go(at)
        else:
            self._say(f"This is the {'last' if by > 0 else 'first'} shot of the reel.")

    def go(self, number: int) -> None:
        """Open a shot by its number, from 0; the present one stays until its picture is there."""
        if self.reel is None:
            return
        shot = self.reel.shots[number]
        if not shot.source:
            self._say(f"{shot.name}: {shot.notes[0]}.")
            return
        self._leave()
        self.at = number
        self._open(shot)

    def focus_of(self, number: int) -> CutFocus:
        """Return the focus at both ends of a shot, of the open one as it is now."""
        is_open = self.reel is not None and number == self.at and self._wanted is None
        if is_open and self.reel is not None and self._source.plate is not None:
            return _focus_of(self._editing.shot, self.reel.shots[number])
        return self.focus[number]

    def _leave(self) -> None:
        """Keep the focus of the open shot for the list, and save it if it has a file."""
        if self._source.plate is None or self._wanted is not None:
            return
        focus = list(self.focus)
        focus[self.at] = self.focus_of(self.at)
        self.focus = tuple(focus)
        if self._documents.path is not None and not self._documents.is_saved:
            self._documents.save()

    def poll(self) -> None:
        """Open the first shot of a reel that has been read, and set the part that the cut shows.

        Raises InputError if the reel is damaged, or none of its media are there.
        """
        read = self._reader.poll()
        if read is not None:
            self._begin(read)
        wanted, shot = self._wanted, self._editing.shot
        if wanted is not None and shot.source == wanted.source and wanted.frames is not None:
            self._wanted = None
            if shot.in_out is None:
                self._editing.edit(replace(shot, in_out=wanted.frames))

    def _begin(self, read: _Read) -> None:
        self.path, self.reel, self.focus = read.path, read.reel, read.focus
        self._wanted = None
        self._preferences.opened(str(read.path))
        there = [at for at, shot in enumerate(read.reel.shots) if shot.source]
        if not there:
            raise InputError(f"{read.path}: the media of all shots are missing.")
        self.at = there[0]
        missing = len(read.reel.missing)
        if missing:
            self._say(f"{missing} of {len(read.reel.shots)} shots have no media here.")
        self._open(read.reel.shots[self.at])

    def _open(self, shot: ReelShot) -> None:
        """Open a shot file or plates; plates that are open already only get another part."""
        if self._documents.opens(shot.source):
            return
        first = None if shot.frames is None else shot.frames.first
        if shot.source == self._editing.shot.source and self._source.plate is not None:
            self._editing.begin(replace(self._editing.shot, in_out=shot.frames))
            self._documents.begun()
            self._editing.frame = self._editing.frame if first is None else first
            return
        self._wanted = shot
        self._source.open(shot.source, self._preferences.options_for(shot.source), first)


def _read(path: Path) -> _Read:
    reel = read_reel(path, EditOptions())
    return _Read(path, reel, tuple(map(_focus_in_file, reel.shots)))


def _focus_in_file(shot: ReelShot) -> CutFocus:
    """Return the focus of a shot with a file; plates have none before they are opened."""
    if not is_shot_file(shot.source):
        return CutFocus()
    try:
        return _focus_of(read_shot(shot.source), shot)
    except HeatlensError:  # told when the shot is opened
        return CutFocus()


def _focus_of(shot: Shot, of_reel: ReelShot) -> CutFocus:
    """Return the focus at the first and the last frame of the cut."""
    frames = of_reel.frames or shot.played
    first, last = (0, 0) if frames is None else (frames.first, frames.last)
    return CutFocus(shot.lens_at(first).focus_distance_m, shot.lens_at(last).focus_distance_m)
