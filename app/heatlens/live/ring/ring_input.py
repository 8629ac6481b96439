"""The interface of lens inputs: a camera on the network, a controller or a game pad."""

import time
from abc import abstractmethod
from collections.abc import Callable, Mapping

from heatlens.base.closing import Closing
from heatlens.live.ring.lens_sample import LensSample
from heatlens.live.ring.sources import SILENT_AFTER_S, Heard, Numbered, RingSources


class RingInput(Closing):
    """An input for the rings of a lens; any thread may call it.

    address   the address or name of the device, for the user
    on_news   called after each sample, on any thread
    """

    address: object
    on_news: Callable[[], None] | None = None
    refused = 0  # number of invalid datagrams
    lost = 0  # number of samples that were never complete
    fault: str | None = None  # why the last datagram was refused

    @abstractmethod
    def heard(self, source: str | None = None) -> Heard:
        """Return the present state of a source; see `RingSources.heard`."""

    @abstractmethod
    def since(self, version: int, source: str | None = None) -> tuple[Numbered, ...]:
        """Return the samples of a source after a version of `heard`; see `RingSources.since`."""

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
        self._sources = RingSources(clock, silent_after_s)

    def take(self, source: str, channels: Mapping[str, float]) -> None:
        """Store values of channels and call `on_news`."""
        self._sources.keep(LensSample(source, channels=dict(channels)))
        if self.on_news is not None:
            self.on_news()

    def heard(self, source: str | None = None) -> Heard:
        """See `RingInput`."""
        return self._sources.heard(source)

    def since(self, version: int, source: str | None = None) -> tuple[Numbered, ...]:
        """See `RingInput`."""
        return self._sources.since(version, source)
