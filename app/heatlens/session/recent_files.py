"""The files that were opened last, as far as they are still there."""

from collections.abc import Callable

from heatlens.background import Background
from heatlens.errors import InputError
from heatlens.session.preferences import Preferences
from heatlens.source.named import source_named


class RecentFiles:
    """Looks on a thread which of the remembered files can still be opened."""

    def __init__(
        self, preferences: Preferences, stream: str | None, wake: Callable[[], None]
    ) -> None:
        """Take `stream`, the name of a renderer that is listened to, which leads the files."""
        self._preferences = preferences
        self._first = () if stream is None else (stream,)
        self._finder: Background[tuple[str, ...]] = Background(wake)
        self.found: tuple[str, ...] = ()

    def look(self) -> None:
        """Begin to look; `found` tells a moment later."""
        names = self._preferences.now.recent
        self._finder.start(lambda: (*self._first, *(name for name in names if _is_there(name))))

    @property
    def is_looking(self) -> bool:
        """Return True while it is not known yet which files are there."""
        return self._finder.is_busy

    @property
    def most(self) -> int:
        """How many files may still be found; 0 once that is known."""
        return len(self._preferences.now.recent) if self.is_looking else 0

    def poll(self) -> None:
        """Take what was found; call this once a frame."""
        found = self._finder.poll()
        self.found = self.found if found is None else found


def _is_there(text: str) -> bool:
    """Return True where a file, a pattern or a folder can still be opened; on a thread."""
    try:
        source_named(text).require()
    except InputError:
        return False
    return True
