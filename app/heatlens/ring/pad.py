"""A game pad or a jog wheel: its axes are channels. Whoever draws the window reads it."""

import time
from collections.abc import Callable, Mapping

from heatlens.ring.lens_sample import LensSample
from heatlens.ring.ring_input import Controls
from heatlens.ring.sources import Heard

_EVERY_S = 0.02


class PadInput(Controls):
    """Asks `read` for the axes whenever it is asked itself, at most so often as a pad changes.

    `read` is set by the window: the libraries of windows answer on its thread alone. It returns the
    axes by their names, or None while nothing is plugged in, which counts as silence.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Begin without a pad."""
        super().__init__("pad", clock)
        self.read: Callable[[], Mapping[str, float] | None] = lambda: None
        self._clock = clock
        self._read_at = -_EVERY_S

    def heard(self, source: str | None = None) -> Heard:
        """Return what the pad tells now."""
        now_s = self._clock()
        if now_s - self._read_at >= _EVERY_S:
            self._read_at = now_s
            axes = self.read()
            if axes is not None:
                self._sources.keep(LensSample(channels=dict(axes)))
        return super().heard(source)

    def seconds_until_due(self) -> float:
        """Return how long the window may sleep before the pad is read again."""
        return _EVERY_S

    def close(self) -> None:
        """Let go of the pad."""
        self.read = lambda: None
