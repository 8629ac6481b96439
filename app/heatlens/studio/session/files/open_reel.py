"""The reel of the session: a cut of which one shot is open, and the way to the others."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from heatlens.core.base.background import Background
from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.model.shot.grade import Grade
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.reel import Reel, ReelShot
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.edit_file import EditOptions
from heatlens.media.documents.reel_file import is_reel, read_reel
from heatlens.media.documents.shot_file import is_shot_file, read_shot
from heatlens.studio.session.files.shot_documents import ShotDocuments
from heatlens.studio.session.files.shot_stills import FirstPicture, ShotStills, Still
from heatlens.studio.session.messages import Worker
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.time.playback import Playback


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

    Going to another shot saves the one that is left if it has a file. The first plate of the next
    shot is read ahead.
    """

    def __init__(
        self,
        shared: Shared,
        documents: ShotDocuments,
        playback: Playback,
        frames_folder: Path | None,
    ) -> None:
        super().__init__(shared)
        self._documents, self._playback = documents, playback
        playback.next_shot = self._play_on
        self._reader: Background[_Read] = Background(self._wake)
        self.path: Path | None = None
        self.reel: Reel | None = None
        self.focus: tuple[CutFocus, ...] = ()  # of each shot, as read or as last left
        self.at = 0  # the number of the open shot
        self._wanted: ReelShot | None = None  # its file or its plates are on their way
        self._left: dict[str, Shot] = {}  # those without a file that were worked on, by source
        self._lent: Grade | None = None  # that of the clip, in a shot without a file
        self._ahead: Background[FirstPicture] = Background(self._wake)
        self._stills = ShotStills(self._wake, frames_folder)
        self._ahead_of = -1  # the shot beside which the next one was read ahead

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
        beside = [at for at in self._there if (at - self.at) * by > 0]
        if beside:
            self.go(min(beside) if by > 0 else max(beside))
        else:
            self._say(f"This is the {'last' if by > 0 else 'first'} shot of the reel.")

    @property
    def _there(self) -> list[int]:
        """The numbers of the shots that have media."""
        shots = () if self.reel is None else self.reel.shots
        return [at for at, shot in enumerate(shots) if shot.source]

    @property
    def _after(self) -> int:
        """The number of the next shot that has media, after the last one of the first."""
        return next((at for at in self._there if at > self.at), self._there[0])

    def _play_on(self) -> bool:
        """Go on in the next shot; return False if there is no other, or another file is open."""
        if self._wanted is not None:
            return True
        if not self.is_open or self._after == self.at or self._editing.performance is not None:
            return False
        self.go(self._after)
        return True

    @property
    def is_open(self) -> bool:
        """True if the shot of the reel is what is open."""
        opened = (self._editing.shot.source, str(self._documents.path))
        return self.reel is not None and self.reel.shots[self.at].source in opened

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
        is_seen = self.reel is not None and number == self.at and self._wanted is None
        if is_seen and self.reel is not None and self._source.plate is not None:
            return _focus_of(self._editing.shot, self.reel.shots[number])
        return self.focus[number]

    def still_of(self, number: int) -> Still | None:
        """Return a small picture of a shot; None until it is read, and if there is none."""
        return self._stills.of(number, self._first_of(number))

    def _first_of(self, number: int) -> Callable[[], FirstPicture]:
        assert self.reel is not None
        shot = self.reel.shots[number]
        return partial(_first_picture, shot, self._preferences.options_for(shot.source))

    def _leave(self) -> None:
        """Keep the focus of the open shot for the list, and save it if it has a file.

        One without a file is kept until the reel comes back to it.
        """
        if self._source.plate is None or self._wanted is not None:
            return
        shot = self._editing.shot
        if self._documents.is_begun_work and shot.source is not None:
            self._left[shot.source] = shot
        focus = list(self.focus)
        focus[self.at] = self.focus_of(self.at)
        self.focus = tuple(focus)
        if self._documents.path is not None and not self._documents.is_saved:
            self._documents.save()

    def poll(self) -> None:
        """Open the first shot of a reel that has been read, and set its in and out points.

        Raises InputError if the reel is damaged, or none of its media are there.
        """
        if (read := self._reader.poll()) is not None:
            self._begin(read)
        if self._wanted is not None:
            self._take(self._wanted)
        elif self.is_open:
            self._look_ahead()

    def _take(self, wanted: ReelShot) -> None:
        """Once the plates are loaded, set in and out points to the range used in the cut."""
        if self.is_open:
            self._wanted = None
            self._playback.is_new_shot = True
            if self._documents.path is None:
                self._set_part(wanted)
        elif not (self._documents.is_reading or self._source.opener.opening):
            self._wanted = None  # opening failed; already reported
            self._playback.stop()

    def _set_part(self, wanted: ReelShot) -> None:
        """Set the frames and the grade of the cut; a shot that was worked on stays as it was left.

        Clips of the same plates share a shot, and each of them lends it its grade.
        """
        left, now = self._left.pop(wanted.source, None), self._editing.shot
        shot = left or replace(now, in_out=None)
        grade = None if shot.grade == self._lent else shot.grade
        part, self._lent = wanted.part_of(replace(shot, grade=grade)), wanted.grade
        if left is not None:
            self._documents.goes_on(part)
        elif part != now:
            self._editing.begin(part)
            self._documents.begun()

    def _look_ahead(self) -> None:
        """Have the first plate of the next shot read."""
        assert self.reel is not None
        if self._ahead_of != self.at:
            self._ahead_of = self.at
            self._ahead.start(self._first_of(self._after))
        next_source = self._ahead.poll()
        if next_source is not None and next_source[0] not in ("", self._editing.shot.source):
            self._source.opener.prepare(*next_source)

    def close(self) -> None:
        """Read no more stills."""
        self._stills.close()

    def _begin(self, read: _Read) -> None:
        self.path, self.reel, self.focus = read.path, read.reel, read.focus
        self._wanted, self._ahead_of = None, -1
        self._left = {}
        self._stills.clear()
        self._preferences.opened(str(read.path))
        if not self._there:
            raise InputError(f"{read.path}: the media of all shots are missing.")
        self.at = self._there[0]
        missing = len(read.reel.missing)
        if missing:
            self._say(f"{missing} of {len(read.reel.shots)} shots have no media here.")
        self._open(read.reel.shots[self.at])

    def _open(self, shot: ReelShot) -> None:
        """Open a shot file or plates; plates that are open already only get another part."""
        self._wanted = shot
        if self._documents.opens(shot.source, shot):
            return
        first = None if shot.frames is None else shot.frames.first
        if shot.source == self._editing.shot.source and self._source.plate is not None:
            self._set_part(shot)
            self._editing.frame = self._editing.frame if first is None else first
            self._wanted = None
            return
        self._source.opener.open(shot.source, self._preferences.options_for(shot.source), first)


def _read(path: Path) -> _Read:
    reel = read_reel(path, EditOptions())
    return _Read(path, reel, tuple(map(_focus_in_file, reel.shots)))


def _first_picture(shot: ReelShot, options: PlateOptions) -> FirstPicture:
    """Return what opening a shot asks for first; the source is "" if its file is damaged."""
    if not is_shot_file(shot.source):
        return shot.source, options, None if shot.frames is None else shot.frames.first
    try:
        read = read_shot(shot.source)
    except HeatlensError:  # told when the shot is opened
        return "", options, None
    played = shot.frames or read.played
    return read.source or "", read.plate_options, None if played is None else played.first


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
