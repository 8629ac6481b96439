"""The steps of a bench, and the time left at the pace so far."""

import time
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass

# Weight of the plan against measurements, as a share of all planned seconds of a kind of steps.
_PLAN_WEIGHT = 0.15


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
        self._step_index = -1  # index of the running step; -1 before the first
        self._bench_start = self._step_start = clock()
        self._plan_s = _seconds_by_kind(self.steps)
        # Planned seconds of the finished steps by kind, and those that they took.
        self._finished_plan_s: dict[str, float] = defaultdict(float)
        self._finished_actual_s: dict[str, float] = defaultdict(float)

    @property
    def number(self) -> int:
        """The number of the running step, counted from 1; 0 before the first."""
        return self._step_index + 1

    def begin_if_step(self, sentence: str) -> bool:
        """Begin the step that has this sentence, and return True; return False if no step has it.

        Steps in between count as skipped.
        """
        later_indices = range(self._step_index + 1, len(self.steps))
        index = next((at for at in later_indices if self.steps[at].sentence == sentence), None)
        if index is None:
            return False
        now_s = self._clock()
        if self._step_index >= 0:
            finished_step = self.steps[self._step_index]
            self._finished_plan_s[finished_step.kind] += finished_step.seconds
            self._finished_actual_s[finished_step.kind] += now_s - self._step_start
        self._step_index, self._step_start = index, now_s
        return True

    @property
    def left_s(self) -> float:
        """Estimated seconds to the end: the rest of the running step and all later steps."""
        later_plan_s = _seconds_by_kind(self.steps[self._step_index + 1 :])
        later_s = sum(
            self._actual_over_planned(kind) * seconds for kind, seconds in later_plan_s.items()
        )
        if self._step_index < 0:
            return later_s
        step = self.steps[self._step_index]
        step_left_s = self._actual_over_planned(step.kind) * step.seconds - (
            self._clock() - self._step_start
        )
        return later_s + max(0.0, step_left_s)

    @property
    def whole_s(self) -> float:
        """Estimated seconds from the beginning to the end."""
        return self._clock() - self._bench_start + self.left_s

    # The estimate is the ratio of actual to planned seconds of the finished steps of a kind, for
    # which a slow machine is slower by about the same factor. A share `_PLAN_WEIGHT` of the plan
    # counts as finished on time, so that the time left does not jump when the first step ends.
    def _actual_over_planned(self, kind: str) -> float:
        """Return the estimated actual seconds per planned second of steps of this kind."""
        plan_weight_s = _PLAN_WEIGHT * self._plan_s[kind]
        planned_s = self._finished_plan_s[kind] + plan_weight_s
        return (
            (self._finished_actual_s[kind] + plan_weight_s) / planned_s if planned_s > 0.0 else 1.0
        )


def _seconds_by_kind(steps: Sequence[Step]) -> dict[str, float]:
    """Return the planned seconds of `steps`, added up for each kind."""
    seconds: dict[str, float] = defaultdict(float)
    for step in steps:
        seconds[step.kind] += step.seconds
    return seconds
