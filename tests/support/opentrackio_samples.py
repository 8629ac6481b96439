"""Samples with the structure of the examples that SMPTE publishes of OpenTrackIO.

The names are those of the standard and the values those of its examples, so that what a reader
makes of them is known; every part that heatlens does not read is there too.
"""

import json
from typing import Any

import cbor2

from heatlens.core.model.timecode import Timecode
from heatlens.media.live.ring.opentrackio import Encoding
from heatlens.media.live.ring.sources import LensSample

_RATE = {"num": 24000, "denom": 1001}
_TIMECODE = {"hours": 1, "minutes": 2, "seconds": 3, "frames": 4, "frameRate": _RATE}
_SOURCE = "urn:uuid:fc9bc480-02bd-4bd0-96c7-bce47197f720"


def _axes(*names: str) -> dict[str, float]:
    return {name: float(index) for index, name in enumerate(names, 1)}


def _transform(name: str, **more: Any) -> dict[str, Any]:
    rotation = {"pan": 180.0, "tilt": 90.0, "roll": 45.0}
    return {"translation": _axes("x", "y", "z"), "rotation": rotation, "id": name} | more


def _recommended() -> dict[str, Any]:
    return {
        "tracker": {"notes": "Generated.", "recording": False, "status": "Optical Good"},
        "timing": {"mode": "external", "sampleRate": _RATE, "timecode": _TIMECODE},
        "lens": {
            "distortion": [{"radial": [1.0, 2.0, 3.0], "tangential": [1.0, 2.0], "overscan": 3.1}],
            "encoders": {"focus": 0.1, "iris": 0.2, "zoom": 0.3},
            "entrancePupilOffset": 0.123,
            "fStop": 4.0,
            "pinholeFocalLength": 24.305,
            "focusDistance": 10.0,
            "projectionOffset": {"x": 0.1, "y": 0.2},
        },
        "protocol": {"name": "OpenTrackIO", "version": [1, 0, 1]},
        "sampleId": "urn:uuid:cd5677eb-b18d-4746-9dc3-2890c0711d52",
        "sourceId": _SOURCE,
        "sourceNumber": 1,
        "transforms": [_transform("Camera")],
    }


def _complete() -> dict[str, Any]:
    sample = _recommended()
    leader = {"leaderIdentity": "00:11:22:33:44:55", "leaderAccuracy": 5e-08, "vlan": 100}
    sample["timing"] |= {
        "mode": "internal",
        "recordedTimestamp": {"seconds": 1718806000, "nanoseconds": 500000000},
        "sampleTimestamp": {"seconds": 1718806554, "nanoseconds": 500000000},
        "sequenceNumber": 0,
        "synchronization": {"locked": True, "source": "ptp", "present": True, "ptp": leader},
    }
    sample["lens"] |= {
        "custom": [1.0, 2.0],
        "distortionOffset": _axes("x", "y"),
        "exposureFalloff": _axes("a1", "a2", "a3"),
        "rawEncoders": {"focus": 1000, "iris": 2000, "zoom": 3000},
        "tStop": 4.1,
    }
    places = ("lat0", "lon0", "h0")
    sample["globalStage"] = _axes("E", "N", "U", *places)
    sample["relatedSampleIds"] = ["urn:uuid:5210332e-0292-4f8e-a606-a23ebe2ae18e"]
    sample["transforms"] = [_transform(n, scale=_axes("x", "y", "z")) for n in ("Dolly", "Crane")]
    sample["custom"] = {"pot1": 2435, "button1": False}
    return sample


def _static() -> dict[str, Any]:
    camera = {
        "captureFrameRate": _RATE,
        "activeSensorPhysicalDimensions": {"height": 24.0, "width": 36.0},
        "activeSensorResolution": {"height": 2160, "width": 3840},
        "anamorphicSqueeze": {"num": 1, "denom": 1},
        "isoSpeed": 4000,
        "label": "A",
    }
    lens = {"make": "LensMaker", "model": "Model15", "nominalFocalLength": 14.0}
    return {"duration": {"num": 1, "denom": 25}, "camera": camera, "lens": lens}


RECOMMENDED = _recommended()
COMPLETE = _complete()
PUBLISHED = {
    "recommended": RECOMMENDED,
    "complete": COMPLETE,
    "recommended with static": RECOMMENDED | {"static": _static()},
    "complete with static": COMPLETE | {"static": _static()},
}
_LENS = (24.305, 0.1, 0.2, 0.3)
READ_AS = {
    name: LensSample(
        *(_SOURCE, 10.0, 4.0, sample["lens"].get("tStop"), *_LENS, Timecode(1, 2, 3, 4)),
        pupil_offset_mm=123.0,
        frames_per_second=24000 / 1001,
    )
    for name, sample in PUBLISHED.items()
}


def encoded_sample(sample: Any, encoding: Encoding) -> bytes:
    """Return a sample encoded as JSON or CBOR."""
    return json.dumps(sample).encode() if encoding is Encoding.JSON else cbor2.dumps(sample)
