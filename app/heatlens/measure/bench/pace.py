"""The steps of a bench, and the time left at the pace so far."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

_PRIOR = 0.15  # weight of the first estimate against measurements, as a part of the whole plan


@dataclass(frozen=True, slots=True)
class Step:
    """A part of the bench: its progress message, and the expected seconds."""

    sentence: str
    seconds: float


class Pace:
    """The progress of a bench through its plan, and the time left at the pace so far."""

    def __init__(
        self, steps: Sequence[Step], clock: Callable[[], float] = time.perf_counter
    ) -> None:
        self.steps = tuple(steps)
        self._clock = clock
        self._at = -1  # the step that goes on
        self._began = clock()
        self._planned = self._taken = 0.0  # seconds of all steps, and of the finished ones

    @property
    def number(self) -> int:
        """The number of the running step, counted from 1; 0 before the first."""
        return self._at + 1

    def begin(self, sentence: str) -> bool:
        """Begin the step with this message; return False if the message belongs to no step.

        Steps in between count as skipped.
        """
        later = range(self._at + 1, len(self.steps))
        found = next((at for at in later if self.steps[at].sentence == sentence), None)
        if found is None:
            return False
        now = self._clock()
        if self._at >= 0:
            self._planned += self.steps[self._at].seconds
            self._taken += now - self._began
        self._at, self._began = found, now
        return True

    @property
    def left_s(self) -> float:
        """Estimated seconds to the end."""
        pace = self._pace
        after = pace * sum(step.seconds for step in self.steps[self._at + 1 :])
        if self._at < 0:
            return after
        current = pace * self.steps[self._at].seconds - (self._clock() - self._began)
        return after + max(0.0, current)

    @property
    def _pace(self) -> float:
        """Actual seconds per planned second."""
        prior = _PRIOR * sum(step.seconds for step in self.steps)
        whole = self._planned + prior
        return (self._taken + prior) / whole if whole > 0.0 else 1.0
