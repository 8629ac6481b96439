"""Open, save and autosave the shot, and offer to recover unsaved changes after a crash."""

from collections.abc import Callable
from concurrent.futures import Future, wait
from dataclasses import dataclass, replace
from pathlib import Path

from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.messages import Problem, Worker
from heatlens.core.model.shot.reel import ReelShot
from heatlens.core.model.shot.shot import Shot
from heatlens.media.camera.samples import CameraSamples
from heatlens.media.camera.shoot_timecode import match_by_timecode
from heatlens.media.documents.shot_file import is_shot_file, unnamed_path
from heatlens.media.sequence.sequence import Sequence
from heatlens.render.source.opened import Opened
from heatlens.studio.session.files.shot_versions import ShotVersions, VersionKind
from heatlens.studio.session.files.unreadable_files import UnreadableFiles
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.shot.shot_store import ShotStore, StoredShot, proposed_name
from heatlens.studio.session.time.timeline import Timeline
from heatlens.studio.settings.start import shot_with_camera

_DISK_S = 5.0  # longest wait for the disk in `autosave_now`


@dataclass(frozen=True)
class Document:
    """A shot and its file; None if it has no file yet."""

    path: Path | None
    shot: Shot
    saved: Shot | None = None  # the shot in the file

    def for_clip(self, clip: ReelShot | None) -> "Document":
        """Return the document with the frames and grade of a clip of a reel; unchanged for None.

        The clip is applied to the saved shot as well, so that a saved document stays saved.
        """
        if clip is None:
            return self
        saved = None if self.saved is None else clip.cut_shot(self.saved)
        return replace(self, shot=clip.cut_shot(self.shot), saved=saved)


class ShotDocuments(Commands, Worker):
    """Opens, saves and autosaves the shot, and offers unsaved changes after a crash."""

    def __init__(self, shared: Shared, timeline: Timeline) -> None:
        super().__init__(shared)
        self._timeline = timeline
        self.store = ShotStore(self._wake)
        self.path: Path | None = None
        self.offer: StoredShot | None = (
            None  # unsaved changes from before a crash, offered to the user
        )
        self._saved: Shot | None = None
        self._autosaved_shot: Shot | None = None  # the shot that is autosaved, or needs no autosave
        self._read_future: Future[StoredShot] | None = None
        self._read_path: Path | None = None  # what is read; None for a shot without a file
        self.versions = ShotVersions(shared, lambda: self._version_name, self.write)
        self.unreadable = UnreadableFiles(shared, self._open_version)
        self.failed_save = ""  # why the shot could not be saved, until the user has answered
        # Writes, each with the shot file that it saves, or None.
        self._writes: list[tuple[Future[None], Path | None]] = []
        self._unnamed_shot = self._editing.shot  # the shot without a file, as it was opened
        self._pending_document: Document | None = None  # its plate is being opened
        self._clip: ReelShot | None = None  # the clip of a reel that is being opened
        self._reported_problem = ""  # the reported reason why autosaving fails

    # Commands

    def open(self, path: Path) -> None:
        """Begin to read a shot file; the open source stays until the new plate has a picture."""
        self._read_path = path.expanduser().absolute()
        self._read_future = self.store.read(self._read_path)

    def try_open(self, text: str, clip: ReelShot | None = None) -> bool:
        """Open `text` if it is a shot file and return True; stop waiting for an earlier shot.

        `clip` is the clip of a reel that uses the shot; None outside a reel.
        """
        self._pending_document = self._read_future = self.offer = self.unreadable.asked = None
        self._clip = clip
        if is_shot_file(text):
            self.open(Path(text))
        return is_shot_file(text)

    def save(self) -> bool:
        """Save the shot to its file; return False if it has no file yet."""
        if self.path is not None:
            self.save_as(self.path)
        return self.path is not None

    def save_as(self, path: Path) -> None:
        """Begin to save the shot to this file, which is its file from now on."""
        self._editing.settle()
        frames = self._timeline.frames if self._timeline.is_sequence else None
        shot = replace(self._editing.shot, frames=frames)
        if shot != self._editing.shot:
            self._editing.do(shot)
        unnamed_path = self._unnamed_path()
        if unnamed_path is not None:  # the shot has a file now, so the other autosave is not needed
            self._track_write(self.store.drop_autosave(unnamed_path))
        self.path, self._saved, self._autosaved_shot = path, shot, shot
        self._writes.append((self.store.save(path, shot), path))
        self.versions.keep(shot, VersionKind.SAVED)
        self._preferences.remember_opened(str(path))

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
        return self._read_future is not None or self.offer is not None

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
        """The name of the shot's file, else of the open file or folder; a star for changes."""
        if self.path is not None:
            return self.title
        plate, sequence = self._source.plate, self._sequence
        name = "" if plate is None else plate.path.name
        if sequence is not None:
            name = sequence.path_at(sequence.first).parent.name
        return f"{name}{' *' if self.has_unnamed_changes else ''}"

    @property
    def has_unnamed_changes(self) -> bool:
        """True for a shot without a file that was changed since its plate was opened."""
        return self.path is None and self._editing.shot != self._unnamed_shot

    def answer(self, recovers: bool) -> None:
        """Answer the offer: recover the unsaved changes, or discard them."""
        offer, self.offer = self.offer, None
        if offer is None:
            return
        is_unnamed = offer.saved is None and offer.path == self._unnamed_path()
        if recovers and offer.unsaved is not None:
            if is_unnamed:
                self._editing.do(offer.unsaved)
            else:
                self._open_document(Document(offer.path, offer.unsaved, offer.saved))
            return
        self._track_write(self.store.drop_autosave(offer.path))
        if offer.saved is not None:
            self._open_document(Document(offer.path, offer.saved, offer.saved))

    # Called by the session

    def finish_opening(self, opened: Opened) -> Shot | None:
        """Return the shot whose plate has been opened, and use its file; None without a shot."""
        pending, self._pending_document = self._pending_document, None
        is_pending = pending is not None and pending.shot.source == opened.text
        if is_pending or opened.text != self._editing.shot.source:
            self._drop_unnamed()
        if pending is None or not is_pending:
            return None
        self.path, self._saved, self._autosaved_shot = pending.path, pending.saved, pending.shot
        self._preferences.remember_opened(str(pending.path))
        return pending.shot

    def begin_unnamed(self) -> None:
        """Begin a shot without a file; read the autosave of an earlier one, to offer it."""
        self.path, self._saved, self._autosaved_shot = None, None, self._editing.shot
        self._unnamed_shot = self._autosaved_shot
        path = self._unnamed_path()
        if path is not None:
            self._read_path, self._read_future = None, self.store.read(path, is_required=False)

    def resume_unnamed(self, shot: Shot) -> None:
        """Continue a shot without a file as it was left, and offer nothing else."""
        self._editing.begin(shot)
        self.path = self._saved = self._autosaved_shot = self._read_future = self.offer = None

    def poll(self) -> None:
        """Handle finished reads and writes, and autosave changes; call this once a frame."""
        self._collect_read()
        self._collect_writes()
        shot, target = self._editing.shot, self._autosave_path
        if self.needs_autosave and target is not None and not self._editing.is_unsettled:
            self._autosaved_shot = shot
            is_saved = self.is_saved
            self._track_write(
                self.store.drop_autosave(target) if is_saved else self.store.autosave(target, shot)
            )
            if not is_saved:
                self.versions.keep(shot, VersionKind.AUTOSAVED)

    @property
    def _version_name(self) -> str | None:
        """The name under which versions of the open shot are kept; None if nothing is open."""
        document = self.path or self._editing.shot.source
        return None if document is None else str(document)

    def write_preferences(self) -> None:
        """Begin to write changed preferences on the thread that writes the shots.

        The window does not wait for the disk, which is slow to confirm a write during an export.
        """
        saving = self._preferences.save_function()
        if saving is not None:
            self.write(saving)

    def autosave_now(self) -> None:
        """Autosave at once, even during a gesture, and wait for the disk.

        Called after a fault of the program or a signal to end it.
        """
        target, shot = self._autosave_path, self._editing.shot
        if (
            target is None
            or self.offer is not None
            or shot == self._autosaved_shot
            or self.is_saved
        ):
            return
        self._autosaved_shot = shot
        write_future = self.store.autosave(target, shot)
        self._track_write(write_future)
        wait([write_future], timeout=_DISK_S)

    @property
    def _autosave_path(self) -> Path | None:
        """The file beside which unsaved changes are kept; None if nothing is open."""
        return self.path or self._unnamed_path()

    @property
    def needs_autosave(self) -> bool:
        """True if there are changes that are not autosaved yet."""
        is_open = self._source.plate is not None and self.offer is None
        return (
            is_open
            and self._autosave_path is not None
            and self._editing.shot != self._autosaved_shot
        )

    # An autosave is offered wherever it differs from its shot. Which of the two is newer is not
    # compared, because clocks are not trusted. A shot that gets its first file is not offered again
    # with its plate.
    def _collect_read(self) -> None:
        """Open the shot file that has been read, or offer its unsaved changes."""
        read_future = self._read_future
        if read_future is None or not read_future.done():
            return
        self._read_future = None
        try:
            document = read_future.result()
        except HeatlensError as error:
            self._report_unreadable(str(error))
            return
        if document.problem:
            self._report_unreadable(document.problem, is_open=True)
        if document.unsaved is not None and document.unsaved != document.saved:
            self.offer = document
        elif document.saved is not None:
            self._open_document(Document(document.path, document.saved, document.saved))

    def _report_unreadable(self, reason: str, is_open: bool = False) -> None:
        """Tell why a shot or its unsaved changes cannot be read, and offer its newest version."""
        path = self._read_path
        name = self._version_name if path is None else str(path)
        version = next(iter(self.versions.of(name)), None)
        self.unreadable.report(reason, path, version, is_open or path is None)

    def _open_version(self, path: Path | None, shot: Shot) -> None:
        """Open a version as the unsaved shot of its file, or of the open picture."""
        if path is None:
            self._editing.do(shot)
        else:
            self._open_document(Document(path, shot))

    def _open_document(self, document: Document) -> None:
        """Open the plate of a shot that has been read, and notify the user."""
        document = document.for_clip(self._clip)
        shot = document.shot
        if shot.source is None:
            self._notify(f"{document.path} names no plate.")
            return
        if document.path is not None and self._command_line.apply_to(str(document.path)):
            start_options = self._command_line.start
            shot = replace(shot, lens=replace(shot.lens, **start_options.lens))
            shot = shot_with_camera(
                shot, _place_by_timecode(start_options.camera, shot), start_options.lens
            )
        self._pending_document = replace(document, shot=shot)
        frame = None if shot.played_frames is None else shot.played_frames.first
        timing = None if shot.framing is None else shot.framing.timing
        self._source.opener.open(shot.source or "", shot.plate_options, frame, timing)

    def _collect_writes(self) -> None:
        """Report the writes that have finished, and each problem once."""
        done_writes = [entry for entry in self._writes if entry[0].done()]
        self._writes = [entry for entry in self._writes if entry not in done_writes]
        for future, path in done_writes:
            try:
                future.result()
                if path is not None:
                    self._notify(f"Saved {path}.")
            except (HeatlensError, OSError) as error:
                if path is not None:
                    self._saved, self.failed_save = None, str(error)
                    self._preferences.forget_opened(str(path))
                if str(error) != self._reported_problem:
                    self._notify(Problem(error))
                self._reported_problem = str(error) if path is None else ""

    def write(self, job: Callable[[], None]) -> None:
        """Begin to call `job`, which writes a file, after all writes before it."""
        self._track_write(self.store.write(job))

    def _track_write(self, future: Future[None]) -> None:
        self._writes.append((future, None))

    def _unnamed_path(self) -> Path | None:
        """Return the file that keeps the unsaved changes of a shot without a file; else None."""
        preferences, source = self._preferences.path, self._editing.shot.source
        if preferences is None or source is None or self.path is not None:
            return None
        return unnamed_path(preferences.parent, source)

    def _drop_unnamed(self) -> None:
        """Delete the autosave of a shot without keys and marks, which is not worth recovering."""
        path, shot = self._unnamed_path(), self._editing.shot
        if path is not None and not (shot.key_frames or shot.marks):
            self._track_write(self.store.drop_autosave(path))

    def close(self) -> None:
        """Autosave, and wait until everything is written."""
        self.autosave_now()
        self._drop_unnamed()
        self.store.close()


def _place_by_timecode(camera: CameraSamples | None, shot: Shot) -> CameraSamples | None:
    """Return the camera with the rows of a table placed on the frames of their timecode."""
    if camera is None or shot.span is None:
        return camera
    first = shot.span.first
    timecode = shot.timecode_at(first)
    start = None if timecode is None else (first, timecode)
    return match_by_timecode(camera, start, shot.frames_per_second, shot.span)
