"""Look up the stamps of many files on a thread, because network folders may be slow."""

from collections.abc import Callable, Iterable
from concurrent.futures import Future
from pathlib import Path

from heatlens.background import Threads
from heatlens.sequence.sequence import Stamp, stamp_of

Stamps = dict[Path, Stamp | None]


class StampBook:
    """The stamps of files at the last look-up; `version` increases whenever they change."""

    def __init__(self, wake: Callable[[], None] = lambda: None) -> None:
        """Set `wake`, which is called on the thread when the files have changed."""
        self.version = 0
        self._wake = wake
        self._stamps: Stamps = {}
        self._thread = Threads("frames-stamps")
        self._looking: Future[Stamps] | None = None

    def look(self, paths: Iterable[Path]) -> None:
        """Begin to look up these files and forget others, unless a look-up is running."""
        self._take()
        if self._looking is None:
            self._looking = self._thread.submit(self._looked, tuple(paths), self._stamps)

    def knows(self, path: Path) -> bool:
        """Return whether the stamp of this file is known."""
        self._take()
        return path in self._stamps

    def stamp(self, path: Path) -> Stamp | None:
        """Return the file's stamp; None if it was missing or never looked up."""
        self._take()
        return self._stamps.get(path)

    def close(self) -> None:
        """Drop look-ups that have not begun, without waiting for one that has."""
        self._thread.close()

    def _take(self) -> None:
        """Take over the results of the thread."""
        if self._looking is None or not self._looking.done():
            return
        found, self._looking = self._looking.result(), None
        if found != self._stamps:
            self._stamps = found
            self.version += 1

    def _looked(self, paths: tuple[Path, ...], before: Stamps) -> Stamps:
        found = {path: stamp_of(path) for path in paths}
        if found != before:
            self._wake()
        return found
