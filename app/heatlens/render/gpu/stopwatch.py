"""Measure the time of each pass, by name.

GPUs are measured by timer queries. Software rasterizers, whose queries return garbage, are measured
by the clock.
"""

import time
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TypeVar

from heatlens.render.gpu.device import Device

Result = TypeVar("Result")


@dataclass(slots=True)
class PassTime:
    """The total time in seconds, and the number of runs, of one pass."""

    seconds: float = 0.0
    runs: int = 0


@dataclass
class Stopwatch:
    """Adds up the times of passes; when off, it costs nothing and the GPU can run ahead."""

    ctx: Device
    is_on: bool = False
    times: dict[str, PassTime] = field(default_factory=dict)

    @contextmanager
    def measure(self, name: str) -> Iterator[None]:
        """Add the time of the GPU work issued inside the block to the pass `name`."""
        if not self.is_on:
            yield
            return
        with self._clock() as seconds:
            yield
        self._add(name, seconds[0])

    def time_steps(self, steps: Generator[str, None, Result]) -> Generator[str, None, Result]:
        """Yield `steps`, and add the time of the work before each name to that name.

        Consecutive steps of one name are one run of that pass.
        """
        previous_name = ""
        while self.is_on:
            with self._clock() as seconds:
                try:
                    name = next(steps)
                except StopIteration as done:
                    return done.value  # type: ignore[no-any-return]
            self._add(name, seconds[0], runs=int(name != previous_name))
            previous_name = name
            yield name
        return (yield from steps)

    def _add(self, name: str, seconds: float, runs: int = 1) -> None:
        """Add a time and a number of runs to the pass `name`."""
        entry = self.times.setdefault(name, PassTime())
        entry.runs += runs
        entry.seconds += seconds

    @contextmanager
    def _clock(self) -> Iterator[list[float]]:
        """Yield a list that holds, after the block, the GPU time in seconds of the work inside."""
        seconds = [0.0]
        if self.ctx.is_software:
            self.ctx.finish()
            start = time.perf_counter()
            yield seconds
            self.ctx.finish()
            seconds[0] = time.perf_counter() - start
        else:
            with self.ctx.timer() as timer:
                yield seconds
            seconds[0] = timer.seconds


def run_seconds(ctx: Device, work: Callable[[], object]) -> float:
    """Return the seconds that `work` takes until the GPU has finished it."""
    ctx.finish()
    start = time.perf_counter()
    work()
    ctx.finish()
    return time.perf_counter() - start
