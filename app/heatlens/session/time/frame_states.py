"""Frame states as runs of equal ones, which the timeline draws under its ruler."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import groupby

from heatlens.frame_cache.cache import FrameCache, FrameState

_PART = 0.05  # the largest share of the time that may be spent on this


@dataclass(frozen=True, slots=True)
class Run:
    """Neighbouring frames, first to last, in the same state."""

    first: int
    last: int
    state: FrameState


class FrameStates:
    """The runs of a cache, updated when it changes, and less often for a long film."""

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self._clock = clock
        self._made_of: object = None
        self._not_before = 0.0
        self._runs: tuple[Run, ...] = ()

    def runs(self, cache: FrameCache, news: object) -> tuple[Run, ...]:
        """Return the current runs; `news` differs whenever they may have changed."""
        now = self._clock()
        if (cache, news) != self._made_of and now >= self._not_before:
            self._runs, self._made_of = runs_of(cache.states()), (cache, news)
            self._not_before = now + (self._clock() - now) / _PART
        return self._runs

    def is_behind(self, cache: FrameCache, news: object) -> bool:
        """Return True while there are changes that `runs` has not returned yet."""
        return (cache, news) != self._made_of


def runs_of(states: Mapping[int, FrameState]) -> tuple[Run, ...]:
    """Join neighbours in the same state; frames that are only on disk are in no run."""
    runs = []
    for state, frames in groupby(states, key=states.__getitem__):
        if state != "absent":
            first = last = next(frames)
            for last in frames:  # noqa: B007  # groupby's iterators have no last
                pass
            runs.append(Run(first, last, state))
    return tuple(runs)
