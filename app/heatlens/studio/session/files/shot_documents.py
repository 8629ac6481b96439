"""Open, save and autosave the shot, and offer to recover unsaved changes after a crash."""

from concurrent.futures import Future, wait
from dataclasses import dataclass, replace
from pathlib import Path

from heatlens.core.base.errors import HeatlensError
from heatlens.core.model.shot.reel import ReelShot
from heatlens.core.model.shot.shot import Shot
from heatlens.media.camera.samples import CameraSamples
from heatlens.media.camera.shoot_timecode import at_timecode
from heatlens.media.documents.shot_file import is_shot_file
from heatlens.media.sequence.sequence import Sequence
from heatlens.render.source.opened import Opened
from heatlens.studio.session.messages import Problem, Worker
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.shot.shot_store import Found, ShotStore, proposed_name, unnamed_path
from heatlens.studio.session.shot.start import shot_with_camera
from heatlens.studio.session.time.timeline import Timeline

_DISK_S = 5.0  # longest wait for the disk in `keep_now`


@dataclass(frozen=True)
class Document:
    """A shot and its file; None if it has no file yet."""

    path: Path | None
    shot: Shot
    saved: Shot | None = None  # the shot in the file

    def within(self, cut: ReelShot | None) -> "Document":
        """Return it as the cut of a reel shows it, if there is one.

        That is no change: what was saved counts as saved.
        """
        if cut is None:
            return self
        saved = None if self.saved is None else cut.part_of(self.saved)
        return replace(self, shot=cut.part_of(self.shot), saved=saved)


class ShotDocuments(Commands, Worker):
    """Opens, saves and autosaves the shot, and offers unsaved changes after a crash."""

    def __init__(self, shared: Shared, timeline: Timeline) -> None:
        super().__init__(shared)
        self._timeline = timeline
        self.store = ShotStore(self._wake)
        self.path: Path | None = None
        self.offer: Found | None = None  # unsaved changes from before a crash, offered to the user
        self._saved: Shot | None = None
        self._kept: Shot | None = None  # the shot that is autosaved, or needs no autosave
        self._reading: Future[Found] | None = None
        self._writing: list[
            tuple[Future[None], str]
        ] = []  # writes, each with the message when it is done
        self._begun = self._editing.shot  # the shot without a file, as it was opened
        self._coming: Document | None = None  # waits for its plate
        self._cut: ReelShot | None = None  # what a reel shows of the shot that is being opened
        self._complained = ""  # the reported reason why autosaving fails

    # Commands

    def open(self, path: Path) -> None:
        """Begin to read a shot file; the open source stays until the new plate has a picture."""
        self._reading = self.store.read(path.expanduser().absolute())

    def opens(self, text: str, cut: ReelShot | None = None) -> bool:
        """Open `text` if it is a shot file and return True; stop waiting for an earlier shot.

        `cut` tells what a reel shows of it.
        """
        self._coming = self._reading = self.offer = None
        self._cut = cut
        if is_shot_file(text):
            self.open(Path(text))
        return is_shot_file(text)

    def save(self) -> bool:
        """Save the shot to its file; return False if it has no file yet."""
        if self.path is not None:
            self.save_as(self.path)
        return self.path is not None

    def save_as(self, path: Path) -> None:
        """Save the shot to this file, which is its file from now on."""
        self._editing.settle()
        frames = self._timeline.frames if self._timeline.is_sequence else None
        shot = replace(self._editing.shot, frames=frames)
        if shot != self._editing.shot:
            self._editing.do(shot)
        unnamed = self._unnamed_path()
        if unnamed is not None:  # it has a file now, so the autosave without file is not needed
            self._track(self.store.drop(unnamed))
        self.path, self._saved, self._kept = path, shot, shot
        self._writing.append((self.store.save(path, shot), f"Saved {path}."))
        self._preferences.opened(str(path))

    def proposed_name(self) -> str:
        """Return a suggested name for the shot's file."""
        if self.path is not None:
            return self.path.name
        assert self._source.plate is not None  # saving is possible only after something was opened
        return proposed_name(self._source.plate.path, self._sequence is not None)

    @property
    def _sequence(self) -> Sequence | None:
        """The sequence of frames that is open; None for a still, a scene or a stream."""
        cache = self._timeline.cache
        return None if cache is None or cache.sequence.is_single else cache.sequence

    @property
    def is_saved(self) -> bool:
        """True if the file has the current shot."""
        return self._saved is not None and self._saved == self._editing.shot

    @property
    def is_reading(self) -> bool:
        """True while a shot file is read, or the user is asked which version to open."""
        return self._reading is not None or self.offer is not None

    @property
    def title(self) -> str:
        """The name of the shot's file, with a star for unsaved changes; "" without a file."""
        return "" if self.path is None else f"{self.path.name}{'' if self.is_saved else ' *'}"

    @property
    def shot_name(self) -> str:
        """The name of the shot's file without its ending; "" without a file."""
        return "" if self.path is None else self.path.name.split(".")[0]

    @property
    def window_title(self) -> str:
        """The name of the shot's file, else of the open source, with a star for unsaved changes."""
        if self.path is not None:
            return self.title
        plate, sequence = self._source.plate, self._sequence
        name = "" if plate is None else plate.path.name
        if sequence is not None:
            name = sequence.form.text
        return f"{name}{' *' if self.is_begun_work else ''}"

    @property
    def is_begun_work(self) -> bool:
        """True for a shot without a file that was changed since its plate was opened."""
        return self.path is None and self._editing.shot != self._begun

    def answer(self, goes_on: bool) -> None:
        """Answer the offer: recover the unsaved changes, or discard them."""
        offer, self.offer = self.offer, None
        if offer is None:
            return
        is_unnamed = offer.saved is None and offer.path == self._unnamed_path()
        if goes_on and offer.unsaved is not None:
            if is_unnamed:
                self._editing.do(offer.unsaved)
            else:
                self._come(Document(offer.path, offer.unsaved, offer.saved))
            return
        self._track(self.store.drop(offer.path))
        if offer.saved is not None:
            self._come(Document(offer.path, offer.saved, offer.saved))

    # Called by the session

    def taken(self, opened: Opened) -> Shot | None:
        """Return the shot whose plate has been opened; None for a plate without a shot."""
        coming, self._coming = self._coming, None
        is_it = coming is not None and coming.shot.source == opened.text
        if is_it or opened.text != self._editing.shot.source:
            self._drop_unnamed()
        if coming is None or not is_it:
            return None
        self.path, self._saved, self._kept = coming.path, coming.saved, coming.shot
        self._preferences.opened(str(coming.path))
        return coming.shot

    def begun(self) -> None:
        """Begin a shot without a file; offer the unsaved changes of an earlier one."""
        self.path, self._saved, self._kept = None, None, self._editing.shot
        self._begun = self._kept
        path = self._unnamed_path()
        if path is not None:
            self._reading = self.store.read(path, is_asked=False)

    def goes_on(self, shot: Shot) -> None:
        """Go on with a shot without a file as it was left, and offer nothing else."""
        self._editing.begin(shot)
        self.path = self._saved = self._kept = self._reading = self.offer = None

    def poll(self) -> None:
        """Handle finished reads and writes, and autosave changes; call this once a frame."""
        self._take_read()
        self._take_written()
        shot, target = self._editing.shot, self._target
        if self.is_behind and target is not None and not self._editing.is_unsettled:
            self._kept = shot
            is_saved = self.is_saved
            self._track(self.store.drop(target) if is_saved else self.store.keep(target, shot))

    def keep_preferences(self) -> None:
        """Begin to write changed preferences beside the shots, so that the loop waits for no disk.

        The disk confirms each write, which takes long while an export uses it.
        """
        saving = self._preferences.saving()
        if saving is not None:
            self._track(self.store.write(saving))

    def keep_now(self) -> None:
        """Autosave at once, even during a gesture, and wait for the disk.

        Called after a fault of the program or a signal to end it.
        """
        target, shot = self._target, self._editing.shot
        if target is None or self.offer is not None or shot == self._kept or self.is_saved:
            return
        self._kept = shot
        keeping = self.store.keep(target, shot)
        self._track(keeping)
        wait([keeping], timeout=_DISK_S)

    @property
    def _target(self) -> Path | None:
        """The file beside which unsaved changes are kept."""
        return self.path or self._unnamed_path()

    @property
    def is_behind(self) -> bool:
        """True if there are changes that are not autosaved yet."""
        is_open = self._source.plate is not None and self.offer is None
        return is_open and self._target is not None and self._editing.shot != self._kept

    # An autosave is offered wherever it differs from its shot. Which of the two is newer is not
    # asked: the clocks that would tell are not trusted. A shot that gets its first file is not
    # offered again with its plate.
    def _take_read(self) -> None:
        reading = self._reading
        if reading is None or not reading.done():
            return
        self._reading = None
        try:
            document = reading.result()
        except HeatlensError as error:
            self._say(Problem(error))
            return
        if document.unsaved is not None and document.unsaved != document.saved:
            self.offer = document
        elif document.saved is not None:
            self._come(Document(document.path, document.saved, document.saved))

    def _come(self, document: Document) -> None:
        """Open the plate of a shot that has been read."""
        document = document.within(self._cut)
        shot = document.shot
        if shot.source is None:
            self._say(f"{document.path} names no plate.")
            return
        if document.path is not None and self._given.are_for(str(document.path)):
            given = self._given.start
            shot = replace(shot, lens=replace(shot.lens, **given.lens))
            shot = shot_with_camera(shot, _on_its_frames(given.camera, shot), given.lens)
        self._coming = replace(document, shot=shot)
        frame = None if shot.played is None else shot.played.first
        timing = None if shot.framing is None else shot.framing.timing
        self._source.opener.open(shot.source or "", shot.plate_options, frame, timing)

    def _take_written(self) -> None:
        done = [entry for entry in self._writing if entry[0].done()]
        self._writing = [entry for entry in self._writing if entry not in done]
        for future, sentence in done:
            try:
                future.result()
                if sentence:
                    self._say(sentence)
            except (HeatlensError, OSError) as error:
                self._saved = None if sentence else self._saved
                if str(error) != self._complained:
                    self._say(Problem(error))
                self._complained = "" if sentence else str(error)

    def _track(self, future: Future[None]) -> None:
        self._writing.append((future, ""))

    def _unnamed_path(self) -> Path | None:
        preferences, source = self._preferences.path, self._editing.shot.source
        if preferences is None or source is None or self.path is not None:
            return None
        return unnamed_path(preferences.parent, source)

    def _drop_unnamed(self) -> None:
        """Delete the autosave of a shot without keys and marks, which is not worth recovering."""
        path, shot = self._unnamed_path(), self._editing.shot
        if path is not None and not (shot.key_frames or shot.marks):
            self._track(self.store.drop(path))

    def close(self) -> None:
        """Autosave, and wait until everything is written."""
        self.keep_now()
        self._drop_unnamed()
        self.store.close()


def _on_its_frames(camera: CameraSamples | None, shot: Shot) -> CameraSamples | None:
    """Return the camera with the rows of a table placed on the frames of their timecode."""
    if camera is None or shot.span is None:
        return camera
    first = shot.span.first
    timecode = shot.timecode_at(first)
    placed = None if timecode is None else (first, timecode)
    return at_timecode(camera, placed, shot.frames_per_second, shot.span)
