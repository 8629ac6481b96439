"""Whether the window has to look at the ring, decided on the thread that hears it.

A camera sends its lens all the time, turned or not. Only a turn is worth a frame of the window at
once; that the ring rests is told often enough by a few frames a second.
"""

import time
from collections.abc import Callable
from dataclasses import replace

from heatlens.ring.lens_sample import LensSample

_RESTING_S = 0.25  # between frames that only tell how often samples come


class RingNews:
    """Wakes the window for what is new; `is_due` until the window has looked."""

    def __init__(
        self, wake: Callable[[], None] = lambda: None, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Begin with no news; `wake`, which is called within `hear`, makes the window draw."""
        self.is_due = False
        self._wake = wake
        self._clock = clock
        self._known: LensSample | None = None
        self._woken_s = -_RESTING_S

    def hear(self, sample: LensSample | None) -> None:
        """Take note of the newest values of the source that is followed."""
        lens = None if sample is None else replace(sample, timecode=None)
        now_s = self._clock()
        if self.is_due or (lens == self._known and now_s - self._woken_s < _RESTING_S):
            return
        self._known, self._woken_s = lens, now_s
        self.is_due = True
        self._wake()

    def take(self) -> None:
        """Take note that the window looks now; call this before it asks what was heard."""
        self.is_due = False
