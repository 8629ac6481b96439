"""Shot files on threads: read, written, and kept beside while they are not saved."""

import hashlib
import re
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from heatlens.documents.shot_file import (
    SHOT_SUFFIX,
    autosave_path,
    newer_autosave,
    read_shot,
    write_autosave,
    write_shot,
)
from heatlens.errors import InputError
from heatlens.faults import faults_told
from heatlens.model.shot import Shot

Result = TypeVar("Result")

_UNSAVED_FOLDER = "unsaved"
_FRAME_NUMBER = re.compile(r"[._-]?\d+$")


@dataclass(frozen=True)
class Found:
    """What lies at a shot file: as it was saved, and what was not saved before a crash."""

    path: Path
    saved: Shot | None  # None: there is no such file, only what was kept of it
    unsaved: Shot | None


class ShotStore:
    """Reads and writes on one thread, so that what is written last is what stays."""

    def __init__(self, wake: Callable[[], None]) -> None:
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="shot-files")
        self._wake = wake

    def read(self, path: Path, is_asked: bool = True) -> Future[Found]:
        """Begin to read; the future raises InputError for what is no shot.

        Where nobody asked for it, nothing may be there.
        """
        return self._begin(lambda: _found(path, is_asked))

    def save(self, path: Path, shot: Shot) -> Future[None]:
        """Begin to write the file."""
        return self._begin(lambda: write_shot(path, shot))

    def keep(self, path: Path, shot: Shot) -> Future[None]:
        """Begin to write beside the file what is not saved."""
        return self._begin(lambda: _kept(path, shot))

    def drop(self, path: Path) -> Future[None]:
        """Begin to remove what was kept beside the file."""
        return self._begin(lambda: autosave_path(path).unlink(missing_ok=True))

    def _begin(self, job: Callable[[], Result]) -> Future[Result]:
        future = self._thread.submit(faults_told("The shot could not be kept or read")(job))
        future.add_done_callback(lambda _: self._wake())
        return future

    def close(self) -> None:
        """Finish what is being written."""
        self._thread.shutdown(wait=True)


def proposed_name(plate: Path, is_numbered: bool) -> str:
    """Return what a shot of this plate is called, unless somebody knows better."""
    stem = _FRAME_NUMBER.sub("", plate.stem) if is_numbered else plate.stem
    return f"{stem or plate.stem}{SHOT_SUFFIX}"


def unnamed_path(folder: Path, source: str) -> Path:
    """Return where a shot without a file is kept: by its plate, in the preferences' folder."""
    digest = hashlib.sha256(source.encode("utf-8", "surrogateescape")).hexdigest()[:16]
    return folder / _UNSAVED_FOLDER / f"{digest}{SHOT_SUFFIX}"


def _found(path: Path, is_asked: bool) -> Found:
    autosave = newer_autosave(path)
    is_there = path.exists() or (is_asked and autosave is None)
    saved = read_shot(path) if is_there else None
    try:
        unsaved = None if autosave is None else read_shot(autosave)
    except InputError:
        if saved is None:
            raise
        unsaved = None  # what the crash cut off in writing is worth nothing
    return Found(path, saved, unsaved)


def _kept(path: Path, shot: Shot) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    write_autosave(path, shot)
