"""The steps of a bench, and the time left at the pace so far."""

import time
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass

_PRIOR = 0.15  # weight of the first estimate against measurements, as a part of the plan of a kind


@dataclass(frozen=True, slots=True)
class Step:
    """A part of the bench: its progress message, and the expected seconds.

    Steps of one kind are expected to be wrong by the same factor.
    """

    sentence: str
    seconds: float
    kind: str = ""


class Pace:
    """The progress of a bench through its plan, and the time left at the pace so far."""

    def __init__(
        self, steps: Sequence[Step], clock: Callable[[], float] = time.perf_counter
    ) -> None:
        self.steps = tuple(steps)
        self._clock = clock
        self._at = -1  # the step that goes on
        self._start = self._began = clock()
        self._whole = _seconds_by_kind(self.steps)
        # Planned seconds of the finished steps by kind, and those that they took.
        self._planned: dict[str, float] = defaultdict(float)
        self._taken: dict[str, float] = defaultdict(float)

    @property
    def number(self) -> int:
        """The number of the running step, counted from 1; 0 before the first."""
        return self._at + 1

    def begin(self, sentence: str) -> bool:
        """Begin the step with this message; return False if the message belongs to no step.

        Steps in between count as skipped.
        """
        later = range(self._at + 1, len(self.steps))
        index = next((at for at in later if self.steps[at].sentence == sentence), None)
        if index is None:
            return False
        now = self._clock()
        if self._at >= 0:
            before = self.steps[self._at]
            self._planned[before.kind] += before.seconds
            self._taken[before.kind] += now - self._began
        self._at, self._began = index, now
        return True

    @property
    def left_s(self) -> float:
        """Estimated seconds to the end."""
        later = _seconds_by_kind(self.steps[self._at + 1 :])
        after = sum(self._pace(kind) * seconds for kind, seconds in later.items())
        if self._at < 0:
            return after
        now = self.steps[self._at]
        current = self._pace(now.kind) * now.seconds - (self._clock() - self._began)
        return after + max(0.0, current)

    @property
    def whole_s(self) -> float:
        """Estimated seconds from the beginning to the end."""
        return self._clock() - self._start + self.left_s

    # A machine that is slower than the plan is so by about the same factor for all steps of a kind.
    # Until such steps have run, the plan is all that is known: it counts as a part of them that
    # took as long as planned, so that the time left does not jump when the first one ends.
    def _pace(self, kind: str) -> float:
        """Actual seconds per planned second of steps of this kind."""
        prior = _PRIOR * self._whole[kind]
        whole = self._planned[kind] + prior
        return (self._taken[kind] + prior) / whole if whole > 0.0 else 1.0


def _seconds_by_kind(steps: Sequence[Step]) -> dict[str, float]:
    seconds: dict[str, float] = defaultdict(float)
    for step in steps:
        seconds[step.kind] += step.seconds
    return seconds
