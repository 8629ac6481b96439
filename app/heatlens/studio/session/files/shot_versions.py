"""Earlier versions of a shot: its last saves and autosaves, kept in the settings folder."""

import hashlib
import re
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum
from functools import partial
from pathlib import Path

from heatlens.core.model.keys.key_rows import key_count
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.shot_file import SHOT_SUFFIX, write_shot
from heatlens.studio.session.shared import Commands, Shared

VERSIONS_MOST = 10  # of one shot
BYTES_MOST = 5_000_000  # of all shots together
_FOLDER = "versions"
_APART_S = 300.0  # a version within this time after an autosave replaces it


class VersionKind(StrEnum):
    """Why a version was kept."""

    SAVED = "saved"
    AUTOSAVED = "autosaved"


_NAME = re.compile(rf"(\d{{13}})-({'|'.join(VersionKind)})-(\d+)-(\d+){re.escape(SHOT_SUFFIX)}")


@dataclass(frozen=True)
class Version:
    """A shot as it was saved or autosaved at a time."""

    path: Path
    written_ms: int  # since 1970
    kind: VersionKind
    mark_count: int
    key_count: int

    @property
    def words(self) -> str:
        """When and how the version was kept, and how many marks and keys it has."""
        clock = datetime.fromtimestamp(self.written_ms / 1e3)
        day = "" if clock.date() == datetime.now().date() else f"{clock:%d %B} "
        counts = ((self.mark_count, "mark"), (self.key_count, "key"))
        counted = ", ".join(f"{count} {word}{'s' * (count != 1)}" for count, word in counts)
        return f"{day}{clock:%H:%M:%S}, {self.kind}: {counted}"


def versions_folder(preferences: Path, document: str) -> Path:
    """Return the folder of the versions of a shot; `document` is its file, or its plate."""
    digest = hashlib.sha256(document.encode("utf-8", "surrogateescape")).hexdigest()[:16]
    return preferences.parent / _FOLDER / digest


def versions_in(folder: Path) -> tuple[Version, ...]:
    """Return the versions in a folder, the newest first."""
    paths = sorted(folder.glob(f"*{SHOT_SUFFIX}"), reverse=True)
    return tuple(it for it in map(_version_of, paths) if it is not None)


def keep_version(folder: Path, shot: Shot, kind: VersionKind, now_s: float) -> None:
    """Write a version of a shot, and delete those that are too many or too large.

    An autosave shortly before is deleted too, as a later version holds what it was for; a save
    stays. `now_s` is the time in seconds since 1970.
    """
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)  # file names are private
    now_ms = int(now_s * 1e3)
    newest = next(iter(versions_in(folder)), None)
    name = f"{now_ms:013d}-{kind}-{len(shot.marks)}-{key_count(shot)}{SHOT_SUFFIX}"
    write_shot(folder / name, shot)
    if newest is not None:
        is_close = (
            newest.kind is VersionKind.AUTOSAVED and now_ms - newest.written_ms < _APART_S * 1e3
        )
        with suppress(FileNotFoundError):  # another window has deleted it
            if is_close or newest.path.read_bytes() == (folder / name).read_bytes():
                newest.path.unlink()
    for version in versions_in(folder)[VERSIONS_MOST:]:
        version.path.unlink(missing_ok=True)
    _limit_size(folder.parent)


def _limit_size(folder: Path) -> None:
    """Delete the oldest versions of all shots until the others fit into `BYTES_MOST`."""
    versions = [version for of_shot in folder.iterdir() for version in versions_in(of_shot)]
    size = 0
    for version in sorted(versions, key=lambda version: version.written_ms, reverse=True):
        with suppress(FileNotFoundError):  # another window has deleted it
            size += version.path.stat().st_size
            if size > BYTES_MOST:
                version.path.unlink()


def _version_of(path: Path) -> Version | None:
    """Return the version in a file; None for a file of another name."""
    match = _NAME.fullmatch(path.name)
    if match is None:
        return None
    return Version(path, int(match[1]), VersionKind(match[2]), int(match[3]), int(match[4]))


class ShotVersions(Commands):
    """The versions of the shots that are opened, in the folder of the preferences."""

    def __init__(
        self,
        shared: Shared,
        document: Callable[[], str | None],
        write: Callable[[Callable[[], None]], None],
    ) -> None:
        """Create it; `document` names the open shot, and `write` calls a job on a thread."""
        super().__init__(shared)
        self._document, self._write = document, write
        self.offered: tuple[Version, ...] | None = None  # until the user has answered

    def of(self, document: str | None) -> tuple[Version, ...]:
        """Return the last saves and autosaves of a shot, the newest first."""
        preferences = self._preferences.path
        if preferences is None or document is None:
            return ()
        return versions_in(versions_folder(preferences, document))

    def of_open(self) -> tuple[Version, ...]:
        """Return the last saves and autosaves of the open shot, the newest first."""
        return self.of(self._document())

    def offer(self) -> None:
        """Ask which version to compare with; the list stays as it is now until the answer."""
        self.offered = self.of_open()

    def keep(self, shot: Shot, kind: VersionKind) -> None:
        """Begin to keep a version of the open shot."""
        document, preferences = self._document(), self._preferences.path
        if preferences is not None and document is not None:
            folder = versions_folder(preferences, document)
            self._write(partial(keep_version, folder, shot, kind, time.time()))
