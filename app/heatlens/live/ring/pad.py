"""Use the axes of a game pad or jog wheel as channels; the window reads the device."""

import time
from collections.abc import Callable, Mapping

from heatlens.live.ring.lens_sample import LensSample
from heatlens.live.ring.ring_input import Controls
from heatlens.live.ring.sources import Heard

_EVERY_S = 0.02


class PadInput(Controls):
    """Reads the axes through `read` on demand, at most as often as a pad changes.

    The window sets `read`, because its library works on the window's thread only. It returns the
    axes by their names, or None while no pad is connected, which counts as silence.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Begin without a pad."""
        super().__init__("pad", clock)
        self.read: Callable[[], Mapping[str, float] | None] = lambda: None
        self._clock = clock
        self._read_at = -_EVERY_S

    def heard(self, source: str | None = None) -> Heard:
        """Return the present state of the pad."""
        now_s = self._clock()
        if now_s - self._read_at >= _EVERY_S:
            self._read_at = now_s
            axes = self.read()
            if axes is not None:
                self._sources.keep(LensSample(channels=dict(axes)))
        return super().heard(source)

    def seconds_until_due(self) -> float:
        """Return the seconds until the pad is to be read again."""
        return _EVERY_S

    def close(self) -> None:
        """Release the pad."""
        self.read = lambda: None
