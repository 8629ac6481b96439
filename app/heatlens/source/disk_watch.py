"""Looks now and then whether frames were added, removed or written again, beside the loop.

A cache reports only what has changed, so that an idle window is not drawn for nothing.
"""

from contextlib import suppress
from threading import Event, Thread

from heatlens.frame_cache.cache import FrameCache

_EVERY_S = 2.0
_FRAMES_A_SECOND = 2000  # a folder with more files is looked at less often


class DiskWatch:
    """A thread that asks `cache` to look at the disk."""

    def __init__(self) -> None:
        self.cache: FrameCache | None = None
        self._is_over = Event()
        Thread(target=self._watch, name="disk-watch", daemon=True).start()

    def _watch(self) -> None:
        while not self._is_over.wait(self._pause_s()):
            with suppress(Exception):  # the cache raises it again where the loop asks for a frame
                if self.cache is not None:
                    self.cache.refresh()

    def _pause_s(self) -> float:
        frames = 0 if self.cache is None else len(self.cache.sequence.frames)
        return max(_EVERY_S, frames / _FRAMES_A_SECOND)

    def close(self) -> None:
        """Stop looking."""
        self._is_over.set()
