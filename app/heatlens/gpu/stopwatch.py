"""Time of each pass, by name. Timer queries on a GPU; wall clock on a software rasteriser, whose
timer queries return garbage."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import moderngl

from heatlens.gpu.context import is_software


@dataclass(slots=True)
class PassTime:
    """Seconds and bytes of all runs of one pass: what it moves, and the least it could."""

    seconds: float = 0.0
    runs: int = 0
    bytes_moved: int = 0
    bytes_least: int = 0


@dataclass
class Stopwatch:
    """Adds up pass times; off, it costs nothing and lets the GPU run ahead."""

    ctx: moderngl.Context
    on: bool = False
    times: dict[str, PassTime] = field(default_factory=dict)

    @contextmanager
    def measure(self, name: str, bytes_moved: int = 0, bytes_least: int = 0) -> Iterator[None]:
        """Time the GPU work issued inside."""
        if not self.on:
            yield
            return
        entry = self.times.setdefault(name, PassTime())
        entry.runs += 1
        entry.bytes_moved += bytes_moved
        entry.bytes_least += bytes_least or bytes_moved
        if is_software(self.ctx):
            self.ctx.finish()
            start = time.perf_counter()
            yield
            self.ctx.finish()
            entry.seconds += time.perf_counter() - start
        else:
            query = self.ctx.query(time=True)
            with query:
                yield
            entry.seconds += query.elapsed * 1e-9
