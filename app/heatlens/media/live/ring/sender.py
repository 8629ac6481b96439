"""Send the lens of a shot as a camera would, to a follow focus or a game engine."""

import socket
import time
from collections.abc import Callable, Iterable
from typing import Protocol

from heatlens.core.base.closing import Closing
from heatlens.core.base.errors import InputError
from heatlens.media.live.ring.address import RingAddress
from heatlens.media.live.ring.opentrackio import Encoding, format_sample, split_into_datagrams
from heatlens.media.live.ring.sources import LensSample


class LensSender(Closing):
    """Sends samples to one address; a `with` block closes it."""

    def __init__(self, address: RingAddress, encoding: Encoding = Encoding.JSON) -> None:
        self.address = address
        self._next_number = (
            1  # number of the next datagram; the standard's receiver ignores a first 0
        )
        self._encoding = encoding
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def send(self, sample: LensSample) -> None:
        """Send one sample. Raise InputError if the network refuses it."""
        text = format_sample(sample, self._encoding, self.address.source_number)
        try:
            for datagram in split_into_datagrams(text, self._encoding, self._next_number):
                self._next_number += 1
                self._socket.sendto(datagram, (self.address.host, self.address.port))
        except OSError as error:
            raise InputError(
                f"Nothing can be sent to {self.address} ({error.strerror or error})."
            ) from error

    def close(self) -> None:
        """Close the socket; a second call does nothing."""
        self._socket.close()


def send_at_rate(
    sender: LensSender,
    samples: Iterable[LensSample],
    rate: float,
    clock: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
) -> None:
    """Send `samples` at `rate` per second; a late sample does not delay the following ones."""
    start_s = clock()
    for number, sample in enumerate(samples):
        wait_s = start_s + number / rate - clock()
        if wait_s > 0:
            sleep(wait_s)
        sender.send(sample)


SOURCE = "heatlens"  # the name of the source in samples of a shot's lens


class Sender(Protocol):
    """Something that sends samples, such as `LensSender`."""

    def send(self, sample: LensSample) -> None:
        """Send one sample. Raise InputError if the network refuses it."""
        ...


class LensOutput:
    """Passes samples to a sender. The first refusal is reported, and ends the sending."""

    def __init__(self, sender: Sender | None, report: Callable[[str], None]) -> None:
        """Send to `sender`, or nothing if None; `report` takes the sentence about a refusal."""
        self._sender = sender
        self._report = report

    @property
    def is_on(self) -> bool:
        """True as long as samples are sent."""
        return self._sender is not None

    def send(self, sample: LensSample) -> None:
        """Send one sample; report the first refusal, after which nothing is sent."""
        if self._sender is None:
            return
        try:
            self._sender.send(sample)
        except InputError as error:
            self._sender = None
            self._report(f"The lens is not sent any more: {error}")
