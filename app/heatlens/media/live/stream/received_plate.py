"""Make a plate of an image that a renderer is still sending, as if it were a file.

A pixel that has not arrived yet is black, transparent and infinitely far.

The lens of the renderer's camera is sent as an image of one pixel, because the protocol of tev
carries only pixels. A client that knows its camera sends the lens as one more image: its name is
`heatlens.lens`, it has 1 x 1 pixel, and its channels are named after the values of the lens. Any
client of tev can send it, and tev itself shows a harmless pixel. In Python:

    with tevclient.Ipc() as tev:
        names = ["focal_length_mm", "sensor_width_mm", "f_stop", "focus_distance_m"]
        tev.create_image("heatlens.lens", 1, 1, names)
        tev.update_image("heatlens.lens", numpy.float32([[[50, 36, 2.8, 4.2]]]), names)

Every channel may be left out, and channels with other names are ignored. The focus distance is in
meters along the optical axis and may be infinite. An impossible value counts as not sent. The image
may be created and updated again whenever the camera changes, before or after the picture; the same
lens applies to all images of a stream. A window that shows the stream takes over the values that
have changed since they were last sent, so a value set by hand in the window stays until the camera
changes.
"""

import math
from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.core.model.lens.lens import LensModel
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.live.stream.chosen_image import ChosenImage, header_of, plate_path
from heatlens.media.live.stream.images import TevImage, unsent_mask
from heatlens.media.plate.depth.depth import finite_range
from heatlens.media.plate.header.camera_header import camera_at_header
from heatlens.media.plate.header.channel_choice import ColorChoice, choose_color, choose_depth
from heatlens.media.plate.header.channels import Header, Part
from heatlens.media.plate.plate import CameraHeader, DepthReport, FloatImage, Plate, read_pixels
from heatlens.media.plate.read import read_color, read_or_estimate_depth

LENS_IMAGE = "heatlens.lens"

# Channel of the image -> the corresponding attribute of an EXR header.
_ATTRIBUTES = {
    "focal_length_mm": "pinholeFocalLength",
    "f_stop": "aperture",
    "focus_distance_m": "focus",
}
_SENSOR = ("sensor_width_mm", "sensor_height_mm")


def plate_of_image(chosen: ChosenImage, options: PlateOptions, lens: Mapping[str, object]) -> Plate:
    """Make the plate of an image; `lens` holds header entries that describe its lens.

    Raises InputError if the channels are not enough for a plate, or no depth has arrived yet.
    """
    image = chosen.image
    path = plate_path(image.name)
    header = {**header_of(image), **lens}
    parts: list[Part] = [(header, dict(image.planes))]
    choice = choose_color(path, [header], options.color_layer)
    is_missing = _fill_missing(path, image, _depth_key(path, header, choice, options))
    color, color_notes = read_color(path, parts, choice)
    depth = read_or_estimate_depth(path, parts, choice, options)
    is_coc = depth.report.convention.facts.is_coc
    depth.values[is_missing] = 0.0 if is_coc else math.inf
    box = Box(0, 0, image.width, image.height)
    return Plate(
        path=path,
        pixels=read_pixels(color, depth.values, is_coc),
        has_alpha=choice.alpha is not None,
        data_window=box,
        display_window=box,
        pixel_aspect_ratio=1.0,
        camera=_camera_of_header(header),
        depth=depth.report if is_coc else _update_range(depth.report, depth.values),
        aovs=chosen.aovs,
        attributes={},
        missing_count=int(np.count_nonzero(is_missing)),
        notes=(*choice.notes, *color_notes, *depth.notes),
    )


def _camera_of_header(header: Header) -> CameraHeader:
    """Return the lens of the header; the default lens model is that of a CG renderer."""
    camera = camera_at_header([header])
    if camera.model is not None:
        return camera
    sources = {**camera.sources, "model": "a running renderer sends the picture"}
    return replace(camera, model=LensModel.RENDERER, sources=sources)


def _depth_key(
    path: Path, header: Header, choice: ColorChoice, options: PlateOptions
) -> str | None:
    """Return the name of the depth channel; None if the depth comes from a file."""
    if options.depth_source is not None:
        return None
    is_coc = options.depth_convention.facts.is_coc
    return choose_depth(path, [header], options.depth_channel, choice, is_coc).key


def _fill_missing(path: Path, image: TevImage, depth_key: str | None) -> NDArray[np.bool_]:
    """Fill missing pixels in place: black for light, repeated values for depth.

    Returns a mask (H, W) of the pixels whose depth is missing.

    Missing depth repeats values that have arrived, so that it does not influence the guess of the
    depth convention. Raises InputError.
    """
    is_depth_missing = np.zeros((image.height, image.width), bool)
    for key, plane in image.planes.items():
        is_missing = unsent_mask(plane)
        if key != depth_key:
            plane[is_missing] = 0.0
            continue
        if is_missing.all():
            raise InputError(f"{path}: no pixel of its depth channel {key!r} has arrived yet.")
        plane[is_missing] = np.resize(plane[~is_missing], np.count_nonzero(is_missing))
        is_depth_missing = is_missing
    return is_depth_missing


def _update_range(report: DepthReport, depth_m: FloatImage) -> DepthReport:
    """Return `report` with the range of `depth_m`."""
    infinite_count = int(np.count_nonzero(np.isinf(depth_m)))
    near_m, far_m = finite_range(depth_m, infinite_count)
    return replace(report, near_m=near_m, far_m=far_m, infinite_count=infinite_count)


def lens_header(image: TevImage | None) -> Mapping[str, object]:
    """Return the values of the lens image as entries of an EXR header.

    Values that have not been sent have no entry. `camera_at_header` checks the values.
    """
    sent_values = {} if image is None else _sent_values(image)
    lens: dict[str, object] = {
        attribute: sent_values[name]
        for name, attribute in _ATTRIBUTES.items()
        if name in sent_values
    }
    sensor_size = [sent_values.get(name, 0.0) for name in _SENSOR]
    return lens | (
        {"sensorOverallDimensions": np.array(sensor_size, np.float32)} if any(sensor_size) else {}
    )


def replace_sent_values(camera: CameraHeader, sent_header: Mapping[str, object]) -> CameraHeader:
    """Return the lens of a file with the values that a client has sent instead of its own."""
    lens = camera_at_header([dict(sent_header)])
    values = {
        lens_field.name: value
        for lens_field in fields(lens)
        if (value := getattr(lens, lens_field.name)) is not None
    }
    return replace(camera, **{**values, "sources": {**camera.sources, **lens.sources}})


def _sent_values(image: TevImage) -> dict[str, float]:
    """Return the first pixel of each channel that a client has sent."""
    first_pixels = {name: plane[:1, :1] for name, plane in image.planes.items()}
    return {
        name: float(pixel[0, 0])
        for name, pixel in first_pixels.items()
        if not unsent_mask(pixel).any()
    }
