"""Look up the files of many frames and their stamps on a thread: network folders may be slow."""

import time
from collections.abc import Callable, Collection, Iterable
from concurrent.futures import Future
from dataclasses import dataclass, field
from pathlib import Path

from heatlens.core.base.background import Threads
from heatlens.media.sequence.sequence import StampedFile, stamp_files

# The thread pauses after so many frames: thousands would keep the window waiting for the
# interpreter, which runs one thread at a time.
_FRAMES_AT_ONCE = 16
_PAUSE_S = 0.0005
_SLOW_FOLDERS = 4  # so many dropped look-ups may still wait for their folders

FilesAt = Callable[[int], tuple[Path, ...]]


@dataclass(frozen=True, eq=False)
class LookUp:
    """The result of a look-up; the same object as the previous one if nothing has changed.

    frames  the files of each frame, with their stamps
    paths   each of these files by its path
    """

    frames: dict[int, tuple[StampedFile, ...]] = field(default_factory=dict)
    paths: dict[Path, StampedFile] = field(default_factory=dict)


class StampBook:
    """The files of frames as they were last looked up.

    `latest` is another object once they change.
    """

    def __init__(self, wake: Callable[[], None] = lambda: None) -> None:
        """Set `wake`, which is called on the thread when the files have changed."""
        self.latest = LookUp()
        self._wake = wake
        self._thread = Threads("frames-stamps", _SLOW_FOLDERS)
        self._pending: Future[LookUp] | None = None

    def forget(self) -> None:
        """Forget all files, and drop a look-up that is running: another source is open."""
        self.latest, self._pending = LookUp(), None

    def keep_only(self, frames: Collection[int]) -> None:
        """Forget the files of other frames than these, and drop a look-up that is running."""
        latest_frames = self.latest.frames
        kept_frames = {frame: latest_frames[frame] for frame in frames if frame in latest_frames}
        self.latest, self._pending = LookUp(kept_frames, self.latest.paths), None

    def start_look_up(self, frames: Iterable[int], files_at: FilesAt) -> None:
        """Begin to look up the files of these frames and forget others, unless one is running.

        `files_at` is called on the thread with each frame, and returns its files.
        """
        self._collect_results()
        if self._pending is None:
            arguments = tuple(frames), files_at, self.latest
            self._pending = self._thread.submit(self._look_up, *arguments)

    @property
    def is_empty(self) -> bool:
        """True before the files of any frame are looked up."""
        self._collect_results()
        return not self.latest.frames

    def files(self, frame: int) -> tuple[StampedFile, ...] | None:
        """Return the files of a frame; None before they are looked up."""
        self._collect_results()
        return self.latest.frames.get(frame)

    def stamped_files(self, paths: Iterable[Path]) -> tuple[StampedFile, ...] | None:
        """Return the files at `paths` as they were looked up for any frame.

        Return None if one of them was not looked up.
        """
        files = [self.latest.paths.get(path) for path in paths]
        found_files = tuple(file for file in files if file is not None)
        return found_files if len(found_files) == len(files) else None

    def close(self) -> None:
        """Drop look-ups that have not begun, without waiting for one that has."""
        self._thread.close()

    def _collect_results(self) -> None:
        """Take over the results of the thread."""
        if self._pending is None or not self._pending.done():
            return
        self.latest, self._pending = self._pending.result(), None

    def _look_up(self, frames: tuple[int, ...], files_at: FilesAt, previous: LookUp) -> LookUp:
        """Return the files of these frames with their stamps; runs on a thread."""
        current = LookUp()
        for count, frame in enumerate(frames, 1):
            files = current.frames[frame] = stamp_files(files_at(frame))
            current.paths.update((file.path, file) for file in files)
            if count % _FRAMES_AT_ONCE == 0:
                time.sleep(_PAUSE_S)
        if current.frames == previous.frames:
            return previous
        self._wake()
        return current
