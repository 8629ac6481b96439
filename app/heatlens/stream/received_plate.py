"""An image that a renderer is still sending, as a plate: read as a file with its channels would be.

A pixel that has not come yet is black, without alpha, and infinitely far.
"""

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray

from heatlens.errors import InputError
from heatlens.model.boxes import Box
from heatlens.model.plate_options import PlateOptions
from heatlens.plate.camera_header import camera_at_header
from heatlens.plate.channel_choice import choose_color, choose_depth
from heatlens.plate.channels import Header, Part
from heatlens.plate.depth import finite_range
from heatlens.plate.depth_read import read_depth_of
from heatlens.plate.plate import DepthReport, FloatImage, Plate, read_pixels
from heatlens.plate.read import read_color
from heatlens.plate.windows import header_at_box
from heatlens.stream.images import TevImage, not_sent

_NAME_LETTERS = 100  # of a plate's path: file systems take 255 bytes


def chosen_channels(image: TevImage, options: PlateOptions) -> TevImage:
    """Copy `image` with nothing but the channels that a plate is made of.

    Raises InputError where it has no colour or no depth.
    """
    path, headers = plate_path(image.name), [_header(image, tuple(image.planes))]
    color = choose_color(path, headers, options.color_layer)
    is_coc = options.depth_convention.facts.is_coc
    depth = choose_depth(path, headers, options.depth_channel, color, is_coc)
    wanted = {ref.key for ref in (*color.rgb, color.alpha, depth) if ref is not None}
    return replace(image, planes={k: p.copy() for k, p in image.planes.items() if k in wanted})


def plate_of_image(image: TevImage, options: PlateOptions, aovs: tuple[str, ...]) -> Plate:
    """Make the plate of what `chosen_channels` returned; `aovs` are all channels of the image.

    `aovs` are all channels of the image as it was sent. Raises InputError where the channels make
    no plate, or no depth has arrived yet.
    """
    path = plate_path(image.name)
    header = _header(image, tuple(image.planes))
    parts: list[Part] = [(header, dict(image.planes))]
    choice = choose_color(path, [header], options.color_layer)
    is_coc = options.depth_convention.facts.is_coc
    ref = choose_depth(path, [header], options.depth_channel, choice, is_coc)
    missing = _missing_in(path, image, ref.key)
    color, color_notes = read_color(path, parts, choice)
    depth = read_depth_of(path, parts, choice, options)
    is_coc = depth.report.convention.facts.is_coc
    depth.values[missing] = 0.0 if is_coc else math.inf
    box = Box(0, 0, image.width, image.height)
    return Plate(
        path=path,
        pixels=read_pixels(color, depth.values, is_coc),
        has_alpha=choice.alpha is not None,
        data_window=box,
        display_window=box,
        pixel_aspect_ratio=1.0,
        camera=camera_at_header([header]),
        depth=depth.report if is_coc else _report_with(depth.report, depth.values),
        aovs=aovs,
        attributes={},
        notes=(*choice.notes, *color_notes, *depth.notes, *_missing_notes(path, missing)),
    )


def plate_path(name: str) -> Path:
    """Return the path that stands for the image `name`; no file is there.

    A client chooses the name, so nothing in it may lead out of a folder.
    """
    plain = "".join(c if c.isprintable() and c not in '/\\:*?"<>|' else "_" for c in name)
    return Path(plain[-_NAME_LETTERS:].strip(". ") or "tev")


def _header(image: TevImage, channels: tuple[str, ...]) -> Header:
    """Return the header that an EXR file with these channels would have."""
    window = header_at_box(Box(0, 0, image.width, image.height))
    return {
        "channels": [SimpleNamespace(name=c, xSampling=1, ySampling=1) for c in channels],
        "dataWindow": window,
        "displayWindow": window,
    }


def _missing_in(path: Path, image: TevImage, depth_key: str) -> NDArray[np.bool_]:
    """Return where there is no depth yet, and fill all that is missing with neutral values.

    The missing depth repeats the values that have arrived, so that the depth convention is guessed
    from those alone.
    """
    for key, plane in image.planes.items():
        missing = not_sent(plane)
        if key != depth_key:
            plane[missing] = 0.0
            continue
        if missing.all():
            raise InputError(f"{path}: no pixel of its depth channel {key!r} has arrived yet.")
        plane[missing] = np.resize(plane[~missing], np.count_nonzero(missing))
        missing_depth = missing
    return missing_depth


def _report_with(report: DepthReport, depth_m: FloatImage) -> DepthReport:
    """Return `report` with the range of `depth_m`."""
    infinite_count = int(np.count_nonzero(np.isinf(depth_m)))
    near_m, far_m = finite_range(depth_m, infinite_count)
    return replace(report, near_m=near_m, far_m=far_m, infinite_count=infinite_count)


def _missing_notes(path: Path, missing: NDArray[np.bool_]) -> tuple[str, ...]:
    """Return a note while the picture is not complete."""
    count = int(np.count_nonzero(missing))
    text = f"{path}: {count} of {missing.size} pixels of its depth have not arrived yet."
    return (text,) if count else ()
