"""Decide, on the thread that receives samples, whether the window has to be drawn for them.

A camera sends its lens all the time. Only a changed value needs a frame of the window at once; the
display of the sample rate is updated a few times a second.
"""

import time
from collections.abc import Callable
from dataclasses import replace

from heatlens.live.ring.lens_sample import LensSample

_RESTING_S = 0.25  # between window frames while no value changes


class RingNews:
    """Wakes the window for changed values; `is_due` is True until the window has handled them."""

    def __init__(
        self, wake: Callable[[], None] = lambda: None, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Create it; `hear` calls `wake` to have the window drawn."""
        self.is_due = False
        self._wake = wake
        self._clock = clock
        self._known: LensSample | None = None
        self._woken_s = -_RESTING_S

    def hear(self, sample: LensSample | None) -> None:
        """Note a new sample of the followed source."""
        lens = None if sample is None else replace(sample, timecode=None)
        now_s = self._clock()
        if self.is_due or (lens == self._known and now_s - self._woken_s < _RESTING_S):
            return
        self._known, self._woken_s = lens, now_s
        self.is_due = True
        self._wake()

    def take(self) -> None:
        """Note that the window handles samples now; call this before it reads them."""
        self.is_due = False
