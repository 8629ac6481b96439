"""The lens of the renderer's camera, sent beside its picture as an image of one pixel.

tev's protocol carries pixels alone. A client that knows its camera sends the lens as one more
image: its name is `heatlens.lens`, it is 1 x 1 pixel, and its channels are called after the values
of the lens. Any client of tev can send it, and tev itself shows a harmless pixel. In Python:

    with tevclient.Ipc() as tev:
        names = ["focal_length_mm", "sensor_width_mm", "f_stop", "focus_distance_m"]
        tev.create_image("heatlens.lens", 1, 1, names)
        tev.update_image("heatlens.lens", numpy.float32([[[50, 36, 2.8, 4.2]]]), names)

Every channel may be left out, and channels of other names are passed over. The focus distance is
metres along the optical axis and may be infinite; it is one value of the thin lens, as the
renderer's own camera has it. A value that no lens can have counts as not sent. The image may be
created and updated again whenever the camera changes, before or after the picture; one lens counts
for all images of a stream. A window that shows the stream takes over the values that have changed
since they were sent last, so that a value set by hand in the window stays until the camera changes.
"""

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

import numpy as np

from heatlens.plate.camera_header import camera_at_header
from heatlens.plate.plate import CameraHeader
from heatlens.stream.images import TevImage, not_sent

LENS_IMAGE = "heatlens.lens"

# Channel of the image -> the attribute that an EXR header would have for it.
_ATTRIBUTES = {
    "focal_length_mm": "pinholeFocalLength",
    "f_stop": "aperture",
    "focus_distance_m": "focus",
}
_SENSOR = ("sensor_width_mm", "sensor_height_mm")


def lens_header(image: TevImage | None) -> Mapping[str, Any]:
    """Return the entries of an EXR header that say what the lens image says.

    What has not been sent has no entry. `camera_at_header` checks the values.
    """
    sent = {} if image is None else _sent_values(image)
    found: dict[str, Any] = {
        attribute: sent[name] for name, attribute in _ATTRIBUTES.items() if name in sent
    }
    sides = [sent.get(name, 0.0) for name in _SENSOR]
    return found | ({"sensorOverallDimensions": np.array(sides, np.float32)} if any(sides) else {})


def with_sent_lens(camera: CameraHeader, sent: Mapping[str, Any]) -> CameraHeader:
    """Return the lens that a file tells, and over it what a client has sent of it."""
    found = camera_at_header([dict(sent)])
    told = {f.name: v for f in fields(found) if (v := getattr(found, f.name)) is not None}
    return replace(camera, **{**told, "sources": {**camera.sources, **found.sources}})


def _sent_values(image: TevImage) -> dict[str, float]:
    """Return the first pixel of each channel that a client has sent."""
    firsts = {name: plane[:1, :1] for name, plane in image.planes.items()}
    return {name: float(first[0, 0]) for name, first in firsts.items() if not not_sent(first).any()}
