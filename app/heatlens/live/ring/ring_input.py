"""The interface of lens inputs: a camera on the network, a controller or a game pad.

The axes of a game pad or jog wheel are channels of `PadInput`; the window reads the device.
"""

import time
from collections.abc import Callable, Mapping

from heatlens.base.closing import Closing
from heatlens.live.ring.sources import SILENT_AFTER_S, Heard, LensSample, RingSources

_EVERY_S = 0.02


class RingInput(Closing):
    """An input for the rings of a lens; any thread may call it.

    address   the address or name of the device, for the user
    sources   what each source has sent
    on_news   called after each sample, on any thread
    """

    address: object
    sources: RingSources
    on_news: Callable[[], None] | None = None
    refused = 0  # number of invalid datagrams
    fault: str | None = None  # why the last datagram was refused

    @property
    def lost(self) -> int:
        """The number of samples that were never complete."""
        return 0

    def heard(self, source: str | None = None) -> Heard:
        """Return the present state of a source; see `RingSources.heard`."""
        return self.sources.heard(source)

    def seconds_until_due(self) -> float | None:
        """Return the seconds until the window must poll the input; None if `on_news` wakes it."""
        return None


class Controls(RingInput):
    """Keeps the channels of a connected controller."""

    def __init__(
        self,
        address: object,
        clock: Callable[[], float] = time.monotonic,
        silent_after_s: float = SILENT_AFTER_S,
    ) -> None:
        """Begin without channels; for `silent_after_s` see `RingSources`."""
        self.address = address
        self.sources = RingSources(clock, silent_after_s)

    def take(self, source: str, channels: Mapping[str, float]) -> None:
        """Store values of channels and call `on_news`."""
        self.sources.keep(LensSample(source, channels=dict(channels)))
        if self.on_news is not None:
            self.on_news()


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
                self.sources.keep(LensSample(channels=dict(axes)))
        return super().heard(source)

    def seconds_until_due(self) -> float:
        """Return the seconds until the pad is to be read again."""
        return _EVERY_S

    def close(self) -> None:
        """Release the pad."""
        self.read = lambda: None
