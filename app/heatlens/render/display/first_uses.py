"""Spread the first use of several passes over frames.

A driver builds the program of a pass when it is first used, for up to 0.2 s, and a window cannot
answer meanwhile. What was built before takes milliseconds. After a slow frame comes one without a
first use, so that input waits for one of them at most.
"""

import time
from collections.abc import Callable, Sequence

_QUICK_S = 0.02  # the uses of a frame that together take less need not be spread


class FirstUses:
    """Counts which of some passes have been used, each at least once."""

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self._clock = clock
        self._used = 0
        self._is_cut_short = False
        self._rests = True  # the frame before was slow, or had the first picture

    def run(self, passes: Sequence[Callable[[], object]]) -> bool:
        """Use the next passes for the first time; return True once what follows may be used too.

        `passes` are in their order, and the same in each frame, with whatever is current. A frame
        ends after a pass that was slow.
        """
        start, waiting = self._clock(), passes[self._used :]
        if waiting and self._rests:
            self._rests, self._is_cut_short = False, True
            return False
        for use in waiting:
            use()
            self._used += 1
            self._rests = self._is_cut_short = self._clock() - start > _QUICK_S
            if self._is_cut_short:
                return False
        self._is_cut_short = False
        return True

    # Once only: what needs the passes may be gone in the next frame, such as a preview that was the
    # last, and a window that went on asking would draw frames forever.
    def take_request(self) -> bool:
        """Return True, once, if a run was cut short, so that another frame should continue it."""
        is_cut_short, self._is_cut_short = self._is_cut_short, False
        return is_cut_short
