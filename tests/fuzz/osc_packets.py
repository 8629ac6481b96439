"""Datagrams of OSC for the fuzzers: messages and bundles, each file one datagram."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from pythonosc.osc_bundle_builder import IMMEDIATELY, OscBundleBuilder
from pythonosc.osc_message_builder import OscMessageBuilder

from heatlens.core.base.errors import HeatlensError
from heatlens.media.live.ring.hearing import SampleCollector
from heatlens.media.live.ring.receiver import OscDecoder


def datagrams(folder: Path) -> list[Path]:
    """Write a message of each kind of value, and a bundle within a bundle."""
    messages = []
    for number, value in enumerate((0.5, 3, "word", b"blob", True, [1, [2.0]])):
        builder = OscMessageBuilder(f"/1/fader{number}")
        builder.add_arg(value)
        builder.add_arg(0.25)
        messages.append(builder.build())
    inner, outer = OscBundleBuilder(IMMEDIATELY), OscBundleBuilder(12.5)
    for message in messages:
        inner.add_content(message)
    outer.add_content(inner.build())
    outer.add_content(messages[0])
    for number, packet in enumerate([*messages, outer.build()]):
        (folder / f"datagram{number}").write_bytes(packet.dgram)
    return sorted(folder.glob("datagram*"))


def received_values(path: Path) -> Iterable[np.ndarray]:
    """Take a datagram as the receiver does. Check that it is counted, and return its values."""
    collector = SampleCollector(OscDecoder())
    collector.accept_datagram(path.read_bytes(), ("stranger", 1))
    assert collector.accepted + collector.refused == 1, "a datagram is not counted"
    sample = collector.sources.source_state().sample
    if sample is None:
        raise HeatlensError(str(collector.fault))
    return [np.array(list(sample.channels.values()))]
