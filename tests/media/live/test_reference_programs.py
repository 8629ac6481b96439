"""OpenTrackIO with the programs of the standard: its sender, its receiver and its schema.

They are in the public repository SMPTE/ris-osvp-metadata-camdkit. HEATLENS_CAMDKIT names a copy of
it; what they need besides is `pip install jsonref jsonschema ntplib`.
"""

import importlib
import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.timecode import Timecode
from heatlens.media.camera.ring_samples import sample_of_shot
from heatlens.media.live.ring.hearing import OpenTrackIODecoder, SampleCollector
from heatlens.media.live.ring.opentrackio import (
    Encoding,
    format_sample,
    source_id,
    split_into_datagrams,
)
from heatlens.media.live.ring.sources import LensSample

FOLDER = os.environ.get("HEATLENS_CAMDKIT", "")
pytestmark = pytest.mark.skipif(
    not FOLDER, reason="HEATLENS_CAMDKIT names no copy of SMPTE/ris-osvp-metadata-camdkit"
)
COUNT = 20  # samples
SHOT = Shot(Lens(50.0, 2.8, 2.0, 36.0), frames_per_second=24000 / 1001).with_start_timecode(
    "10:00:00:00"
)


@pytest.fixture(scope="module")
def schema():
    """Return the schema, made by the repository itself."""
    for name in ("jsonref", "jsonschema", "ntplib"):
        pytest.importorskip(name)
    source = Path(FOLDER) / "src"
    maker = [sys.executable, str(source / "tools/python/generate_opentrackio_schema.py")]
    paths = os.pathsep.join((str(source / "main/python"), *sys.path))
    environment = os.environ | {"PYTHONPATH": paths}
    made = subprocess.run(maker, env=environment, capture_output=True, check=True)
    sys.path.insert(0, str(source / "test/python/parser"))
    yield json.loads(made.stdout)
    sys.path.remove(str(source / "test/python/parser"))


@pytest.fixture
def receiver(schema):
    """Return a receiver of the standard; `taken` has each sample that it has parsed."""
    module = importlib.import_module("opentrackio_receiver")
    text = json.dumps(schema)
    place = {"verbose": False, "multicast_group": "239.135.1.1", "port": 55555}
    made = module.OpenTrackIOPacketReceiver(place | {"schema_text": text})
    made.taken, process = [], made._process_payload
    made._process_payload = lambda: process() and made.taken.append(dict(made.protocol.pd))
    return made


@pytest.fixture
def transmitter(schema):
    """Return a function that makes a sender of the standard."""
    module = importlib.import_module("opentrackio_sender")
    library = importlib.import_module("opentrackio_lib")

    def made(encoding: Encoding, count: int):
        known = {"source_number": 1, "port": 55555, "multicast_group": "239.135.1.1"}
        known |= {"debug": False, "time_source": library.TimeSource.NONE, "num-segments": count}
        form = library.PayloadFormat(encoding.value)
        return module.OpenTrackIOPacketTransmitter(known | {"format": form})

    return made


@pytest.mark.parametrize("count", range(5), ids="segments {}".format)
@pytest.mark.parametrize("encoding", Encoding, ids=lambda it: it.name)
def test_hearing_takes_every_sample_of_reference_sender(transmitter, encoding, count):
    collector, sender = SampleCollector(OpenTrackIODecoder()), transmitter(encoding, count)
    datagrams = [it for _ in range(COUNT) for it in sender._create_opentrackio_packet()]
    for datagram in datagrams:
        collector.accept_datagram(datagram, ("127.0.0.1", 1))
    assert (collector.accepted, collector.refused, collector.lost) == (len(datagrams), 0, 0)
    assert collector.sources.version == COUNT
    sample = collector.sources.source_state().sample
    assert sample is not None and sample.source == f"urn:uuid:{sender._source_uuid}"
    assert (sample.focus_distance_m, sample.f_stop, sample.pupil_offset_mm) == (10.0, 4.0, 123.0)


def test_hearing_follows_restarted_reference_sender(transmitter):
    now = [0.0]
    collector = SampleCollector(OpenTrackIODecoder(), lambda: now[0])
    for port in range(3):
        sender = transmitter(Encoding.JSON, 2)
        now[0] += 60.0
        for datagram in sender._create_opentrackio_packet():
            collector.accept_datagram(datagram, ("127.0.0.1", port))
        sample = collector.sources.source_state().sample
        assert sample is not None and sample.source == f"urn:uuid:{sender._source_uuid}"


def samples_for_datagrams(count: int) -> list[LensSample]:
    """Return samples of a shot; with `count` above 1 they have rings, for more datagrams."""
    samples = [
        sample_of_shot("s", SHOT, at, SHOT.timecode_at(at, first_frame=0)) for at in range(COUNT)
    ]
    turns = {"focus_turn": 0.25, "iris_turn": 0.5, "zoom_turn": 1.0, "pupil_offset_mm": -12.5}
    return samples if count == 1 else [replace(sample, **turns) for sample in samples]


@pytest.mark.parametrize("count", range(1, 5), ids="segments {}".format)
@pytest.mark.parametrize("encoding", Encoding, ids=lambda it: it.name)
def test_reference_receiver_takes_every_sample_of_ours(monkeypatch, receiver, encoding, count):
    number = 1
    for sample in samples_for_datagrams(count):
        text = format_sample(sample, encoding)
        limit_name = "heatlens.media.live.ring.opentrackio.MAX_SEGMENT_BYTES"
        monkeypatch.setattr(limit_name, -(-len(text) // count))
        datagrams = list(split_into_datagrams(text, encoding, number))
        assert len(datagrams) == count
        assert all(receiver._parse_packet(datagram) for datagram in datagrams)
        number += count
    assert len(receiver.taken) == COUNT
    protocol = receiver.protocol
    assert protocol.get_timecode() == "10:00:00:19"
    assert protocol.get_timecode_framerate() == 24000 / 1001
    assert (protocol.get_focus_distance(), protocol.get_focal_length()) == (2.0, 50.0)


@pytest.mark.parametrize("drop", [False, True], ids=["counted", "drop frame"])
@pytest.mark.parametrize("count", [1, 2], ids=["lens", "lens and rings"])
def test_sample_text_passes_schema_of_the_standard(schema, drop, count):
    import jsonschema

    for sample in samples_for_datagrams(count):
        timecode = Timecode(hours=10, minutes=0, seconds=0, frames=2, drop=drop)
        content = json.loads(format_sample(replace(sample, timecode=timecode), Encoding.JSON, 200))
        jsonschema.validate(content, schema)
        assert content["sourceId"] == source_id("s")
