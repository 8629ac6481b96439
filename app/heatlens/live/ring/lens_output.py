"""Send lens samples until the network refuses one."""

from collections.abc import Callable
from typing import Protocol

from heatlens.base.errors import InputError
from heatlens.live.ring.lens_sample import LensSample

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
        """Send one sample, or do nothing after a refusal."""
        if self._sender is None:
            return
        try:
            self._sender.send(sample)
        except InputError as error:
            self._sender = None
            self._report(f"The lens is not sent any more: {error}")
