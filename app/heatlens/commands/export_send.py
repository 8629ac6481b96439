"""`--send` of an export: the lens of each frame that is done, as a camera sends its own."""

import argparse
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from heatlens.camera.ring_samples import sample_of_lens
from heatlens.commands.say import say
from heatlens.errors import InputError
from heatlens.model.shot import Shot
from heatlens.ring.address import opentrackio_address
from heatlens.ring.sender import LensSender

_SOURCE = "heatlens"


def add_send_option(parser: argparse.ArgumentParser) -> None:
    """Add `--send` to the options of an export."""
    parser.add_argument_group("sending live").add_argument(
        "--send",
        metavar="PROTOCOL[://HOST:PORT]",
        help="send the lens of each frame that is done, to an engine or another heatlens: "
        "opentrackio for this machine, or opentrackio://HOST:PORT. `heatlens camera --send` plays "
        "it in real time",
    )


@contextmanager
def sending(address: str | None, shot: Shot) -> Iterator[Callable[[int], None]]:
    """Yield a function that sends the lens of a frame; it does nothing if `address` is None.

    An export does not end because a network refuses the lens: that is reported once. Raises
    InputError for an address that cannot be sent to.
    """
    if address is None:
        yield lambda frame: None
        return
    with LensSender(opentrackio_address(address), shot.frames_per_second) as sender:
        yield _SendFrame(sender, shot)


class _SendFrame:
    """Sends the lens of a frame, until the network refuses."""

    def __init__(self, sender: LensSender, shot: Shot) -> None:
        self._sender: LensSender | None = sender
        self._shot = shot

    def __call__(self, frame: int) -> None:
        if self._sender is None:
            return
        lens, rate = self._shot.lens_at(frame), self._shot.frames_per_second
        try:
            self._sender.send(sample_of_lens(_SOURCE, lens, frame, rate))
        except InputError as error:
            self._sender = None
            say(f"The lens is not sent any more: {error}")
