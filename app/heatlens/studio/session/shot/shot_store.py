"""Read, write and autosave shot files on a thread."""

import re
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TypeVar

from heatlens.core.base.background import Threads
from heatlens.core.base.errors import InputError
from heatlens.core.base.faults import report_faults
from heatlens.core.model.keys.key_rows import key_count
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.shot_file import (
    SHOT_SUFFIX,
    autosave_path,
    read_shot,
    write_autosave,
    write_shot,
)

Result = TypeVar("Result")

_MAX_READS = 4  # number of shots that can be opened while a disk does not answer
_FRAME_NUMBER = re.compile(r"[._-]?\d+$")


@dataclass(frozen=True)
class StoredShot:
    """The content of a shot file: the saved shot, and unsaved changes from before a crash."""

    path: Path
    saved: Shot | None  # None if there is no file, only unsaved changes
    unsaved: Shot | None
    left_at: float = 0.0  # when the unsaved changes were written, in seconds since 1970
    problem: str = ""  # why the unsaved changes cannot be read, which are left out

    @property
    def words(self) -> str:
        """When the shot was left, and how many marks and keys it has that are not saved."""
        clock = datetime.fromtimestamp(self.left_at)
        day = "" if clock.date() == datetime.now().date() else f"{clock:%d %B} "
        shot = self.unsaved
        counts = {"mark": 0, "key": 0}
        if shot is not None:
            counts = {"mark": len(shot.marks), "key": key_count(shot)}
        counted = ", ".join(f"{n} {word}{'s' * (n != 1)}" for word, n in counts.items())
        return f"You left this shot unsaved at {day}{clock:%H:%M}: {counted}."


class ShotStore:
    """Writes on a single thread, so that the latest write wins; reads after all earlier writes.

    A read that hangs does not delay the writes.
    """

    def __init__(self, wake: Callable[[], None]) -> None:
        self._writer = ThreadPoolExecutor(1, thread_name_prefix="shot-write")
        self._readers = Threads("shot-read", _MAX_READS)
        self._wake = wake

    def read(self, path: Path, is_required: bool = True) -> Future[StoredShot]:
        """Begin to read; the future raises InputError if the file is not a shot.

        With `is_required` False, a missing file is not an error.
        """
        earlier_writes = self._writer.submit(lambda: None)

        def read_after_writes() -> StoredShot:
            earlier_writes.result()
            return _read_both(path, is_required)

        return self._submit(self._readers, read_after_writes)

    def save(self, path: Path, shot: Shot) -> Future[None]:
        """Begin to save the file."""
        return self._submit(self._writer, lambda: write_shot(path, shot))

    def autosave(self, path: Path, shot: Shot) -> Future[None]:
        """Begin to write unsaved changes beside the file."""
        return self._submit(self._writer, lambda: _write_beside(path, shot))

    def drop_autosave(self, path: Path) -> Future[None]:
        """Begin to remove the unsaved changes beside the file."""
        return self._submit(self._writer, lambda: autosave_path(path).unlink(missing_ok=True))

    def write(self, job: Callable[[], None]) -> Future[None]:
        """Begin to call `job`, which writes another file, after all writes before it."""
        return self._submit(self._writer, job)

    def _submit(
        self, threads: ThreadPoolExecutor | Threads, job: Callable[[], Result]
    ) -> Future[Result]:
        """Run `job` on a thread, and wake the window when it is done."""
        future = threads.submit(report_faults("The shot could not be saved or read")(job))
        future.add_done_callback(lambda _: self._wake())
        return future

    def close(self) -> None:
        """Wait until everything is written, but not for reads."""
        self._readers.close()
        self._writer.shutdown(wait=True)


def proposed_name(plate: Path, is_numbered: bool) -> str:
    """Return the default file name for a shot of this plate."""
    stem = _FRAME_NUMBER.sub("", plate.stem) if is_numbered else plate.stem
    return f"{stem or plate.stem}{SHOT_SUFFIX}"


def _read_both(path: Path, is_required: bool) -> StoredShot:
    """Read a shot file and its autosave.

    File times are not compared, because clocks differ and are set back.
    """
    autosave = autosave_path(path)
    has_autosave = autosave.is_file()
    reads_file = path.exists() or (is_required and not has_autosave)
    saved = read_shot(path) if reads_file else None
    problem = ""
    try:
        unsaved = read_shot(autosave) if has_autosave else None
    except InputError as error:  # the crash interrupted the autosave
        if saved is None:
            raise
        unsaved, problem = None, f"{path.name} is as it was saved; its unsaved changes: {error}"
    left_at = autosave.stat().st_mtime if unsaved is not None else 0.0
    return StoredShot(path, saved, unsaved, left_at, problem)


def _write_beside(path: Path, shot: Shot) -> None:
    """Write the autosave of a shot beside its file."""
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)  # file names are private
    write_autosave(path, shot)
