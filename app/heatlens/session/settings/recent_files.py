"""Find out which recently opened files still exist."""

from heatlens.base.background import Background
from heatlens.base.errors import InputError
from heatlens.session.loop.worker import Worker
from heatlens.session.shared import Commands, Shared
from heatlens.source.named import source_named


class RecentFiles(Commands, Worker):
    """Checks on a thread which of the remembered files can still be opened."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        stream = shared.given.start.stream
        self._first = () if stream is None else (stream.text,)  # what is listened to comes first
        self._finder: Background[tuple[str, ...]] = Background(self._wake)
        self.found: tuple[str, ...] = ()

    def look(self) -> None:
        """Begin to check; `found` has the result a moment later."""
        names = self._preferences.now.recent
        self._finder.start(lambda: (*self._first, *(name for name in names if _is_there(name))))

    @property
    def is_looking(self) -> bool:
        """True while the check is running."""
        return self._finder.is_busy

    @property
    def most(self) -> int:
        """The largest number of files that may still be found; 0 once the check has ended."""
        return len(self._preferences.now.recent) if self.is_looking else 0

    def poll(self) -> None:
        """Take the result of the check; call this once a frame."""
        found = self._finder.poll()
        self.found = self.found if found is None else found


def _is_there(text: str) -> bool:
    """Return True if a file, pattern or folder still exists; runs on a thread."""
    try:
        source_named(text).require()
    except InputError:
        return False
    return True
