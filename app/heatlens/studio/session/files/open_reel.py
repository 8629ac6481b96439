"""The reel of the session: a cut of which one shot is open, and the way to the others."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from heatlens.core.base.background import Background
from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.messages import Worker
from heatlens.core.model.shot.grade import Grade
from heatlens.core.model.shot.reel import CutFocus, Reel, ReelShot
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.reel_file import is_reel
from heatlens.studio.session.files.reel_reading import (
    LoadedReel,
    cut_times,
    first_picture_of,
    focus_of,
    load_reel,
)
from heatlens.studio.session.files.shot_documents import ShotDocuments
from heatlens.studio.session.files.shot_stills import FirstPicture, ShotStills, Still
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.time.playback import Playback


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
        self._reader: Background[LoadedReel] = Background(self._wake)
        self.path: Path | None = None
        self.reel: Reel | None = None
        self.saved: Reel | None = None  # the reel in the file
        self._focus: dict[str, CutFocus] = {}  # of each shot by name, as read or as last left
        self.number = 0  # the number of the open shot
        self._folders: tuple[Path, ...] = ()  # where media are looked for too
        self._requested_shot: ReelShot | None = None  # the shot that is being opened
        self._unsaved_shots: dict[str, Shot] = {}  # edited shots without a file, by source
        self._clip_grade: Grade | None = None  # the grade of the clip in a shot without a file
        self._next_shot_reader: Background[FirstPicture] = Background(self._wake)
        self._stills = ShotStills(self._wake, frames_folder)
        self._read_ahead_number = -1  # the shot that was open when the next one was read ahead

    @property
    def title(self) -> str:
        """The name of the reel, and which of its shots is open; "" if none is."""
        if self.reel is None or not self.is_open:
            return ""
        shot = self.reel.shots[self.number]
        return f"{self.name}, {self.number + 1} of {len(self.reel.shots)}: {shot.name}"

    @property
    def name(self) -> str:
        """The name of the reel's file, with a star for unsaved changes."""
        name = "New reel" if self.path is None else self.path.name
        return f"{name} *" if self.reel != self.saved else name

    def begin(self, reel: Reel) -> None:
        """Begin a new reel without a file; this opens none of its shots."""
        self._use(LoadedReel(None, reel, {}))

    def leave(self) -> None:
        """Leave the reel; its open shot stays open."""
        self._leave_shot()
        self.path = self.reel = self.saved = self._requested_shot = None

    def change(self, reel: Reel, added_focus: Sequence[CutFocus] = ()) -> None:
        """Use the changed reel; `added_focus` is the focus of its last shots.

        The open shot stays open. If it is not in the reel any more, the next one is opened.
        """
        assert self.reel is not None
        open_name = self.reel.shots[self.number].name
        names = [shot.name for shot in reel.shots]
        if is_gone := open_name not in names:
            self._leave_shot()
        self.reel, self._read_ahead_number = reel, -1
        self._focus |= dict(zip(reversed(names), reversed(added_focus), strict=False))
        self.number = self.number - 1 if is_gone else names.index(open_name)
        if is_gone and self._available_numbers:
            self.number = self._next_number
            self._open_shot(reel.shots[self.number])

    def try_open(self, text: str) -> bool:
        """Begin to open `text` if it is a reel or an edit, and return whether it is one."""
        if is_reel(text):
            self._folders = ()
            self._reader.start(partial(load_reel, Path(text).expanduser().absolute()))
        return is_reel(text)

    def look_in(self, folder: Path) -> None:
        """Read the open reel again, and look for missing media in another folder too."""
        if self.path is not None:
            self._folders = (*self._folders, folder)
            self._reader.start(partial(load_reel, self.path, self._folders))

    @property
    def why_not(self) -> str:
        """Why there is no other shot to go to; "" if there is one."""
        return "" if self.reel is not None else "No reel and no edit is open."

    def step(self, direction: int) -> None:
        """Go to the next shot or the one before, past those whose media are missing."""
        if self.reel is None:
            return
        candidates = [
            number for number in self._available_numbers if (number - self.number) * direction > 0
        ]
        if candidates:
            self.go(min(candidates) if direction > 0 else max(candidates))
        else:
            self._notify(f"This is the {'last' if direction > 0 else 'first'} shot of the reel.")

    @property
    def _available_numbers(self) -> list[int]:
        """The numbers of the shots that have media."""
        shots = () if self.reel is None else self.reel.shots
        return [number for number, shot in enumerate(shots) if shot.source]

    @property
    def _next_number(self) -> int:
        """The number of the next shot that has media; the first such shot follows the last."""
        return next(
            (number for number in self._available_numbers if number > self.number),
            self._available_numbers[0],
        )

    def play_next_shot(self) -> bool:
        """Play on in the next shot; return False if there is no other, or another file is open."""
        if self._requested_shot is not None:
            return True
        if (
            not self.is_open
            or self._next_number == self.number
            or self._editing.performance is not None
        ):
            return False
        self.go(self._next_number)
        return True

    @property
    def is_open(self) -> bool:
        """True if the shot of the reel is what is open."""
        open_names = (self._editing.shot.source, str(self._documents.path))
        return self.reel is not None and self.reel.shots[self.number].source in open_names

    def go(self, number: int) -> None:
        """Open a shot by its number, from 0; the present one stays until its picture is there."""
        if self.reel is None:
            return
        shot = self.reel.shots[number]
        if not shot.source:
            self._notify(f"{shot.name}: {shot.notes[0]}.")
            return
        self._leave_shot()
        self.number = number
        self._open_shot(shot)

    def edited_shot(self, source: str) -> Shot | None:
        """Return the shot of a source if it was edited and has no file; else None."""
        if self._documents.has_unnamed_changes and source == self._editing.shot.source:
            return self._editing.shot
        return self._unsaved_shots.get(source)

    def focus_of(self, number: int) -> CutFocus:
        """Return the focus at both ends of a shot; for the open shot, as it is now."""
        if self.reel is None:
            return CutFocus()
        is_current = number == self.number and self._requested_shot is None
        if is_current and self._source.plate is not None:
            return focus_of(self._editing.shot, self.reel.shots[number])
        return self._focus.get(self.reel.shots[number].name, CutFocus())

    def still_of(self, number: int) -> Still | None:
        """Return a small picture of a shot; None until it is read, and if there is none."""
        assert self.reel is not None
        return self._stills.still(self.reel.shots[number], self._first_picture_function(number))

    def _first_picture_function(self, number: int) -> Callable[[], FirstPicture]:
        """Return the function that finds the first picture of a shot; for a thread."""
        assert self.reel is not None
        shot = self.reel.shots[number]
        return partial(first_picture_of, shot, self._preferences.options_for(shot.source))

    def _leave_shot(self) -> None:
        """Keep the focus of the open shot for the list, and save it if it has a file.

        A shot without a file is kept until the reel comes back to it.
        """
        if self._source.plate is None or self._requested_shot is not None:
            return
        shot = self._editing.shot
        if self._documents.has_unnamed_changes and shot.source is not None:
            self._unsaved_shots[shot.source] = shot
        if self.reel is not None:
            self._focus[self.reel.shots[self.number].name] = self.focus_of(self.number)
        if self._documents.path is not None and not self._documents.is_saved:
            self._documents.save()

    def poll(self) -> None:
        """Open the first shot of a reel that has been read, and set its in and out points."""
        try:
            self._begin_reel(self._reader.poll())
        except HeatlensError as error:
            self._documents.unreadable.report(str(error))
        self._playback.cut = cut_times(self.reel, self.number) if self.is_open else None
        if self._requested_shot is not None:
            self._finish_opening(self._requested_shot)
        elif self.is_open:
            self._read_next_shot()

    def _finish_opening(self, clip: ReelShot) -> None:
        """Set in and out points once the plates are loaded; if opening failed, stop playback."""
        if self.is_open:
            self._requested_shot = None
            self._playback.is_new_shot = True
            if self._documents.path is None:
                self._apply_clip(clip)
        elif not (self._documents.is_reading or self._source.opener.opening):
            self._requested_shot = None  # opening failed; already reported
            self._playback.stop()

    def _apply_clip(self, clip: ReelShot) -> None:
        """Set the frames and the grade of the clip; a shot that was edited keeps its edits.

        Clips of the same plates share a shot, which takes the grade of the open clip.
        """
        kept_shot, current_shot = self._unsaved_shots.pop(clip.source, None), self._editing.shot
        shot = kept_shot or replace(current_shot, in_out=None)
        grade = None if shot.grade == self._clip_grade else shot.grade
        clip_shot, self._clip_grade = clip.cut_shot(replace(shot, grade=grade)), clip.grade
        if kept_shot is not None:
            self._documents.resume_unnamed(clip_shot)
        elif clip_shot != current_shot:
            self._editing.begin(clip_shot)
            self._documents.begin_unnamed()

    def _read_next_shot(self) -> None:
        """Read the first plate of the next shot ahead."""
        assert self.reel is not None
        if self._read_ahead_number != self.number:
            self._read_ahead_number = self.number
            self._next_shot_reader.start(self._first_picture_function(self._next_number))
        next_source = self._next_shot_reader.poll()
        if next_source is not None and next_source[0] not in ("", self._editing.shot.source):
            self._source.opener.prepare(*next_source)

    def close(self) -> None:
        """Read no more stills."""
        self._stills.close()

    def _begin_reel(self, loaded: LoadedReel | None) -> None:
        """Use a reel that has been read, and open its first shot that has media."""
        if loaded is None:
            return
        self._use(loaded)
        if not self._available_numbers:
            words = f"None of the pictures of {loaded.path} are here."
            return self._documents.unreadable.report(words, lacks_media=True)
        self.number = self._available_numbers[0]
        self._open_shot(loaded.reel.shots[self.number])

    def _use(self, loaded: LoadedReel) -> None:
        """Use a reel, and nothing of the one before."""
        self.path, self.reel, self._focus = loaded.path, loaded.reel, loaded.focus
        self.saved = None if loaded.path is None else loaded.reel
        self._requested_shot, self._read_ahead_number, self.number = None, -1, 0
        self._unsaved_shots = {}
        self._stills.clear()
        if loaded.path is not None:
            self._preferences.remember_opened(str(loaded.path))

    def _open_shot(self, shot: ReelShot) -> None:
        """Open a shot file or plates; plates that are open already only get another clip."""
        self._requested_shot = shot
        if self._documents.try_open(shot.source, shot):
            return
        first_frame = None if shot.frames is None else shot.frames.first
        if shot.source == self._editing.shot.source and self._source.plate is not None:
            self._apply_clip(shot)
            self._editing.frame = self._editing.frame if first_frame is None else first_frame
            self._requested_shot = None
            return
        self._source.opener.open(
            shot.source, self._preferences.options_for(shot.source), first_frame
        )
