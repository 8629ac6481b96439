"""`--send` of an export: the lens of each frame that is done, as a camera sends its own."""

import argparse
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from heatlens.camera.ring_samples import sample_of_shot
from heatlens.commands.options.shot_timecode import shot_timecodes
from heatlens.commands.output.say import say
from heatlens.live.ring.address import opentrackio_address
from heatlens.live.ring.lens_output import SOURCE, LensOutput
from heatlens.live.ring.sender import LensSender
from heatlens.model.shot import Shot


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
def sending(address: str | None, shot: Shot, first: int) -> Iterator[Callable[[int], None]]:
    """Yield a function that sends the lens of a frame; it does nothing if `address` is None.

    `first` is the first of the frames.

    A network that refuses the lens does not end the export: that is only reported. Raise
    InputError for an invalid address.
    """
    if address is None:
        yield lambda frame: None
        return
    with LensSender(opentrackio_address(address)) as sender:
        output, timecode_at = LensOutput(sender, say), shot_timecodes(shot, first)

        def send(frame: int) -> None:
            output.send(sample_of_shot(SOURCE, shot, frame, timecode_at(frame)))

        yield send
