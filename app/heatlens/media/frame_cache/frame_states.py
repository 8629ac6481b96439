"""The states of the frames of a cache, as runs of equal ones."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import groupby

from heatlens.media.frame_cache.cache import FrameCache, FrameState

_MAX_SHARE = 0.05  # the largest share of the time that may be spent on updating the runs


@dataclass(frozen=True, slots=True)
class Run:
    """Neighboring frames, first to last, in the same state."""

    first: int
    last: int
    state: FrameState


class FrameStates:
    """The runs of a cache, updated when it changes, and less often for a long film."""

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self._clock = clock
        self._runs_key: object = None
        self._next_update_s = 0.0
        self._runs: tuple[Run, ...] = ()

    def runs(self, cache: FrameCache, version: object) -> tuple[Run, ...]:
        """Return the runs; they are computed again if `version` changed, but not too often."""
        now_s = self._clock()
        if (cache, version) != self._runs_key and now_s >= self._next_update_s:
            self._runs, self._runs_key = runs_of(cache.states()), (cache, version)
            self._next_update_s = now_s + (self._clock() - now_s) / _MAX_SHARE
        return self._runs

    def is_outdated(self, cache: FrameCache, version: object) -> bool:
        """Return True while there are changes that `runs` has not returned yet."""
        return (cache, version) != self._runs_key


def runs_of(states: Mapping[int, FrameState]) -> tuple[Run, ...]:
    """Join neighbors in the same state; frames that are only on disk are in no run."""
    runs = []
    for state, frames in groupby(states, key=states.__getitem__):
        if state != "absent":
            first = last = next(frames)
            for last in frames:  # noqa: B007  # groupby's iterators have no last
                pass
            runs.append(Run(first, last, state))
    return tuple(runs)
