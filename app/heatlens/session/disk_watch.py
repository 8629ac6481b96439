"""Looks now and then whether frames came, went or were written again, beside the loop.

A cache tells only news, so that a window in which nothing happens is not drawn for it.
"""

from contextlib import suppress
from threading import Event, Thread

from heatlens.frame_cache.cache import FrameCache

_EVERY_S = 2.0
_FRAMES_A_SECOND = 2000  # a folder with more files is looked at more seldom


class DiskWatch:
    """A thread that asks `cache` to look at the disk."""

    def __init__(self) -> None:
        self.cache: FrameCache | None = None
        self._is_over = Event()
        Thread(target=self._watch, name="disk-watch", daemon=True).start()

    def _watch(self) -> None:
        while not self._is_over.wait(self._pause_s()):
            with suppress(Exception):  # what a cache cannot go on with, it says to the loop as well
                if self.cache is not None:
                    self.cache.refresh()

    def _pause_s(self) -> float:
        frames = 0 if self.cache is None else len(self.cache.sequence.frames)
        return max(_EVERY_S, frames / _FRAMES_A_SECOND)

    def close(self) -> None:
        """Look no more."""
        self._is_over.set()
