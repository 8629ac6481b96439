"""Look up the files of many frames and their stamps on a thread: network folders may be slow."""

import time
from collections.abc import Callable, Collection, Iterable
from concurrent.futures import Future
from dataclasses import dataclass, field
from pathlib import Path

from heatlens.core.base.background import Threads
from heatlens.render.source.source import StampedFile, stamped

# The thread pauses after so many frames: thousands would keep the window waiting for the
# interpreter, which runs one thread at a time.
_FRAMES_AT_ONCE = 16
_PAUSE_S = 0.0005
_SLOW_FOLDERS = 4  # so many dropped look-ups may still wait for their folders

FilesAt = Callable[[int], tuple[Path, ...]]


@dataclass(frozen=True, eq=False)
class LookedUp:
    """The result of a look-up; one that finds nothing new returns the object of the last one."""

    frames: dict[int, tuple[StampedFile, ...]] = field(default_factory=dict)
    paths: dict[Path, StampedFile] = field(default_factory=dict)


class StampBook:
    """The files of frames as they were last looked up.

    `looked_up` is another object once they change.
    """

    def __init__(self, wake: Callable[[], None] = lambda: None) -> None:
        """Set `wake`, which is called on the thread when the files have changed."""
        self.looked_up = LookedUp()
        self._wake = wake
        self._thread = Threads("frames-stamps", _SLOW_FOLDERS)
        self._looking: Future[LookedUp] | None = None

    def forget(self) -> None:
        """Forget all files, and drop a look-up that is running: another source is open."""
        self.looked_up, self._looking = LookedUp(), None

    def keep(self, frames: Collection[int]) -> None:
        """Forget the files of other frames than these, and drop a look-up that is running."""
        known = self.looked_up.frames
        kept = {frame: known[frame] for frame in frames if frame in known}
        self.looked_up, self._looking = LookedUp(kept, self.looked_up.paths), None

    def look(self, frames: Iterable[int], files_at: FilesAt) -> None:
        """Begin to look up the files of these frames and forget others, unless one is running.

        `files_at` is called on the thread with each frame, and returns its files.
        """
        self._take()
        if self._looking is None:
            asked = tuple(frames), files_at, self.looked_up
            self._looking = self._thread.submit(self._looked, *asked)

    @property
    def is_empty(self) -> bool:
        """True before the files of any frame are looked up."""
        self._take()
        return not self.looked_up.frames

    def files(self, frame: int) -> tuple[StampedFile, ...] | None:
        """Return the files of a frame; None before they are looked up."""
        self._take()
        return self.looked_up.frames.get(frame)

    def stamped(self, paths: Iterable[Path]) -> tuple[StampedFile, ...] | None:
        """Return files as they were looked up for any frame; None if one was not."""
        files = [self.looked_up.paths.get(path) for path in paths]
        known = tuple(file for file in files if file is not None)
        return known if len(known) == len(files) else None

    def close(self) -> None:
        """Drop look-ups that have not begun, without waiting for one that has."""
        self._thread.close()

    def _take(self) -> None:
        """Take over the results of the thread."""
        if self._looking is None or not self._looking.done():
            return
        self.looked_up, self._looking = self._looking.result(), None

    def _looked(self, frames: tuple[int, ...], files_at: FilesAt, before: LookedUp) -> LookedUp:
        now = LookedUp()
        for count, frame in enumerate(frames, 1):
            files = now.frames[frame] = stamped(files_at(frame))
            now.paths.update((file.path, file) for file in files)
            if count % _FRAMES_AT_ONCE == 0:
                time.sleep(_PAUSE_S)
        if now.frames == before.frames:
            return before
        self._wake()
        return now
