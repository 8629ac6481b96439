"""Tell what to do about a shot file, a reel or unsaved changes that cannot be read."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from heatlens.core.base.background import Background
from heatlens.core.base.messages import Problem, Worker
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.shot_file import read_shot
from heatlens.studio.session.files.shot_versions import Version
from heatlens.studio.session.shared import Commands, Shared


@dataclass(frozen=True)
class Unreadable:
    """A document that cannot be read, or a part of it.

    reason       a sentence
    path         the shot file that its kept version belongs to; None for a shot without a file
    version      the newest version that is kept of it; None without one
    is_open      its picture is open, and only unsaved changes are missing
    lacks_media  it is a reel, and all its pictures are missing
    """

    reason: str
    path: Path | None = None
    version: Version | None = None
    is_open: bool = False
    lacks_media: bool = False


class UnreadableFiles(Commands, Worker):
    """Asks about the document that could not be read, and opens its kept version."""

    def __init__(self, shared: Shared, use: Callable[[Path | None, Shot], None]) -> None:
        """Create it; `use` opens a version as the shot of its file."""
        super().__init__(shared)
        self._use = use
        self._reader: Background[tuple[Path | None, Shot]] = Background(self._wake)
        self.asked: Unreadable | None = None  # until the user has answered

    def report(
        self,
        reason: str,
        path: Path | None = None,
        version: Version | None = None,
        is_open: bool = False,
        lacks_media: bool = False,
    ) -> None:
        """Notify the user, and ask what to do; see `Unreadable`."""
        self.asked = Unreadable(reason, path, version, is_open, lacks_media)
        self._notify(Problem(reason))

    def answer(self, opens_version: bool) -> None:
        """End the question; read the kept version if the user wants it."""
        asked, self.asked = self.asked, None
        if opens_version and asked is not None and (version := asked.version) is not None:
            self._reader.start(lambda: (asked.path, read_shot(version.path)))

    def poll(self) -> None:
        """Use a version that has been read; call this once a frame."""
        if (read := self._reader.poll()) is not None:
            self._use(*read)
