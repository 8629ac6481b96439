"""Something that turns the rings of a lens: a camera on the network, a controller, a game pad."""

import time
from abc import abstractmethod
from collections.abc import Callable, Mapping

from heatlens.closing import Closing
from heatlens.ring.lens_sample import LensSample
from heatlens.ring.sources import SILENT_AFTER_S, Heard, Numbered, RingSources


class RingInput(Closing):
    """What the window asks, whoever sends; any thread may ask.

    address   where it is, as people write it
    on_news   called after a sample was taken, on whatever thread that was
    """

    address: object
    on_news: Callable[[], None] | None = None
    refused = 0  # datagrams that were no use
    lost = 0  # samples that were never whole
    fault: str | None = None  # why the last datagram was refused

    @abstractmethod
    def heard(self, source: str | None = None) -> Heard:
        """Return what `source` tells now; None listens to the one that was heard first."""

    @abstractmethod
    def since(self, version: int, source: str | None = None) -> tuple[Numbered, ...]:
        """Return the samples of a source after a version of `heard`; see `RingSources.since`."""

    def seconds_until_due(self) -> float | None:
        """Return how long the window may sleep before it has to ask; None: it is woken."""
        return None


class Controls(RingInput):
    """Keeps the channels of a controller that is plugged in."""

    def __init__(
        self,
        address: object,
        clock: Callable[[], float] = time.monotonic,
        silent_after_s: float = SILENT_AFTER_S,
    ) -> None:
        """Keep what `take` is given; `silent_after_s` is as in `RingSources`."""
        self.address = address
        self._sources = RingSources(clock, silent_after_s)

    def take(self, source: str, channels: Mapping[str, float]) -> None:
        """Keep values of channels and tell of them."""
        self._sources.keep(LensSample(source, channels=dict(channels)))
        if self.on_news is not None:
            self.on_news()

    def heard(self, source: str | None = None) -> Heard:
        """See `RingInput`."""
        return self._sources.heard(source)

    def since(self, version: int, source: str | None = None) -> tuple[Numbered, ...]:
        """See `RingInput`."""
        return self._sources.since(version, source)
