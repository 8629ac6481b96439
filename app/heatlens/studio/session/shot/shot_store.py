"""Read, write and autosave shot files on a thread."""

import hashlib
import re
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from heatlens.core.base.background import Threads
from heatlens.core.base.errors import InputError
from heatlens.core.base.faults import faults_reported
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.shot_file import (
    SHOT_SUFFIX,
    autosave_path,
    read_shot,
    write_autosave,
    write_shot,
)

Result = TypeVar("Result")

_READS_MOST = 4  # so many shots can be opened while a disk does not answer
_UNSAVED_FOLDER = "unsaved"
_FRAME_NUMBER = re.compile(r"[._-]?\d+$")


@dataclass(frozen=True)
class Found:
    """The content of a shot file: the saved shot, and unsaved changes from before a crash."""

    path: Path
    saved: Shot | None  # None if there is no file, only unsaved changes
    unsaved: Shot | None


class ShotStore:
    """Writes on a single thread, so that the latest write wins; reads after the writes before.

    A read that hangs does not delay the writes.
    """

    def __init__(self, wake: Callable[[], None]) -> None:
        self._writer = ThreadPoolExecutor(1, thread_name_prefix="shot-write")
        self._readers = Threads("shot-read", _READS_MOST)
        self._wake = wake

    def read(self, path: Path, is_asked: bool = True) -> Future[Found]:
        """Begin to read; the future raises InputError if the file is not a shot.

        With `is_asked` False, a missing file is not an error.
        """
        written = self._writer.submit(lambda: None)

        def read() -> Found:
            written.result()
            return _found(path, is_asked)

        return self._begin(self._readers, read)

    def save(self, path: Path, shot: Shot) -> Future[None]:
        """Begin to save the file."""
        return self._begin(self._writer, lambda: write_shot(path, shot))

    def keep(self, path: Path, shot: Shot) -> Future[None]:
        """Begin to write unsaved changes beside the file."""
        return self._begin(self._writer, lambda: _kept(path, shot))

    def drop(self, path: Path) -> Future[None]:
        """Begin to remove the unsaved changes beside the file."""
        return self._begin(self._writer, lambda: autosave_path(path).unlink(missing_ok=True))

    def write(self, job: Callable[[], None]) -> Future[None]:
        """Begin to call `job`, which writes another file, after all writes before it."""
        return self._begin(self._writer, job)

    def _begin(
        self, threads: ThreadPoolExecutor | Threads, job: Callable[[], Result]
    ) -> Future[Result]:
        future = threads.submit(faults_reported("The shot could not be saved or read")(job))
        future.add_done_callback(lambda _: self._wake())
        return future

    def close(self) -> None:
        """Wait until everything is written; reading stops without being waited for."""
        self._readers.close()
        self._writer.shutdown(wait=True)


def proposed_name(plate: Path, is_numbered: bool) -> str:
    """Return the default file name for a shot of this plate."""
    stem = _FRAME_NUMBER.sub("", plate.stem) if is_numbered else plate.stem
    return f"{stem or plate.stem}{SHOT_SUFFIX}"


def unnamed_path(folder: Path, source: str) -> Path:
    """Return the autosave path of a shot without a file: named after its source, in `folder`."""
    digest = hashlib.sha256(source.encode("utf-8", "surrogateescape")).hexdigest()[:16]
    return folder / _UNSAVED_FOLDER / f"{digest}{SHOT_SUFFIX}"


def _found(path: Path, is_asked: bool) -> Found:
    """Read both files. File times are not compared, because clocks differ and are set back."""
    autosave = autosave_path(path)
    is_kept = autosave.is_file()
    is_there = path.exists() or (is_asked and not is_kept)
    saved = read_shot(path) if is_there else None
    try:
        unsaved = read_shot(autosave) if is_kept else None
    except InputError:
        if saved is None:
            raise
        unsaved = None  # the crash interrupted its writing
    return Found(path, saved, unsaved)


def _kept(path: Path, shot: Shot) -> None:
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)  # it names unreleased work
    write_autosave(path, shot)
