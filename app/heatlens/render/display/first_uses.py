"""Spread the first use of several passes over frames.

A driver builds the program of a pass when it is first used, for up to 0.2 s, and a window cannot
answer meanwhile. What was built before takes milliseconds.
"""

import time
from collections.abc import Callable, Sequence

_QUICK_S = 0.02  # the uses of a frame that together take less need not be spread


class FirstUses:
    """Counts which of some passes have been used, each at least once."""

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self._clock = clock
        self._used = 0
        self.is_spreading = False  # the next frame continues

    def run(self, passes: Sequence[Callable[[], object]]) -> bool:
        """Use the next passes for the first time; return True once what follows may be used too.

        `passes` are in their order, and the same in each frame, with whatever is current. A frame
        ends after a pass that was slow.
        """
        start = self._clock()
        for use in passes[self._used :]:
            use()
            self._used += 1
            self.is_spreading = self._clock() - start > _QUICK_S
            if self.is_spreading:
                return False
        self.is_spreading = False
        return True
