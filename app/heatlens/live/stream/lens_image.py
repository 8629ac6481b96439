"""Receive the lens of the renderer's camera, which is sent as an image of one pixel.

The protocol of tev carries only pixels. A client that knows its camera sends the lens as one more
image: its name is `heatlens.lens`, it has 1 x 1 pixel, and its channels are named after the values
of the lens. Any client of tev can send it, and tev itself shows a harmless pixel. In Python:

    with tevclient.Ipc() as tev:
        names = ["focal_length_mm", "sensor_width_mm", "f_stop", "focus_distance_m"]
        tev.create_image("heatlens.lens", 1, 1, names)
        tev.update_image("heatlens.lens", numpy.float32([[[50, 36, 2.8, 4.2]]]), names)

Every channel may be left out, and channels with other names are ignored. The focus distance is in
metres along the optical axis and may be infinite. An impossible value counts as not sent. The image
may be created and updated again whenever the camera changes, before or after the picture; the same
lens applies to all images of a stream. A window that shows the stream takes over the values that
have changed since they were last sent, so a value set by hand in the window stays until the camera
changes.
"""

from collections.abc import Mapping
from dataclasses import fields, replace

import numpy as np

from heatlens.live.stream.images import TevImage, not_sent
from heatlens.plate.header.camera_header import camera_at_header
from heatlens.plate.plate import CameraHeader

LENS_IMAGE = "heatlens.lens"

# Channel of the image -> the corresponding attribute of an EXR header.
_ATTRIBUTES = {
    "focal_length_mm": "pinholeFocalLength",
    "f_stop": "aperture",
    "focus_distance_m": "focus",
}
_SENSOR = ("sensor_width_mm", "sensor_height_mm")


def lens_header(image: TevImage | None) -> Mapping[str, object]:
    """Return the values of the lens image as entries of an EXR header.

    Values that have not been sent have no entry. `camera_at_header` checks the values.
    """
    sent = {} if image is None else _sent_values(image)
    found: dict[str, object] = {
        attribute: sent[name] for name, attribute in _ATTRIBUTES.items() if name in sent
    }
    sides = [sent.get(name, 0.0) for name in _SENSOR]
    return found | ({"sensorOverallDimensions": np.array(sides, np.float32)} if any(sides) else {})


def with_sent_lens(camera: CameraHeader, sent: Mapping[str, object]) -> CameraHeader:
    """Return the lens of a file, with the values that a client has sent in place of its own."""
    found = camera_at_header([dict(sent)])
    values = {f.name: v for f in fields(found) if (v := getattr(found, f.name)) is not None}
    return replace(camera, **{**values, "sources": {**camera.sources, **found.sources}})


def _sent_values(image: TevImage) -> dict[str, float]:
    """Return the first pixel of each channel that a client has sent."""
    firsts = {name: plane[:1, :1] for name, plane in image.planes.items()}
    return {name: float(first[0, 0]) for name, first in firsts.items() if not not_sent(first).any()}
