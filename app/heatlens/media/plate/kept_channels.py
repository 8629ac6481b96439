"""Channels of a plate that are copied unchanged to the output: AOVs, ID mattes, the depth."""

from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.files.picture_formats import is_picture
from heatlens.media.plate.exr.exr_read import is_deep_file
from heatlens.media.plate.header.channel_choice import choose_color
from heatlens.media.plate.header.channels import (
    ChannelRef,
    Header,
    flat_channels,
    listed,
    pixels_of,
)
from heatlens.media.plate.mattes.cryptomatte import METADATA
from heatlens.media.plate.parts.header_read import read_headers
from heatlens.media.plate.plate import Plate
from heatlens.media.plate.read import color_file_parts
from heatlens.media.plate.windows import box_at_header, moved_to_window

ALL = "all"


def kept_channels(
    plate: Plate, options: PlateOptions, wanted: Sequence[str]
) -> tuple[dict[str, NDArray[np.generic]], dict[str, Any]]:
    """Return pixels (H, W) by full name over the plate's data window, and attributes they need.

    `wanted` are names of layers or channels, or "all". The colour is never included, because it is
    what is rendered. Raises InputError for a name that the file does not have.
    """
    if not wanted:
        return {}, {}
    parts = color_file_parts(plate.path, options)
    headers = [header for header, _ in parts]
    chosen = _chosen(plate.path, headers, options, wanted)
    kept: dict[str, NDArray[np.generic]] = {}
    for ref in chosen:
        source = box_at_header(headers[ref.part], "dataWindow")
        pixels = pixels_of(parts, ref)
        if source != plate.data_window:
            pixels = moved_to_window(pixels, source, plate.data_window, 0.0)
        kept[ref.full_name] = pixels
    return kept, _id_attributes(headers) if kept else {}


def check_kept(path: Path, options: PlateOptions, wanted: Sequence[str]) -> None:
    """Raise InputError for anything that `kept_channels` would refuse, without reading pixels."""
    if is_picture(path):
        raise InputError(f"{path} is not an EXR file: it has no other channels to keep.")
    if is_deep_file(path):
        raise InputError(
            f"{path} is a deep file: its other channels have several values in a pixel, which "
            "cannot be kept beside a picture. Leave --keep-channels out."
        )
    _chosen(path, read_headers(path), options, wanted)


def _chosen(
    path: Path, headers: Sequence[Header], options: PlateOptions, wanted: Sequence[str]
) -> list[ChannelRef]:
    """Return the wanted layers and channels, in the order of the file."""
    color = choose_color(path, headers, options.color_layer, options.eye)
    refs = [ref for ref in flat_channels(headers) if ref not in (*color.rgb, color.alpha)]
    if ALL in wanted:
        return refs
    chosen: set[ChannelRef] = set()
    for name in wanted:
        named = [ref for ref in refs if _is_called(ref, name.lower())]
        if not named:
            raise _unknown(path, refs, name)
        chosen.update(named)
    return [ref for ref in refs if ref in chosen]


def _unknown(path: Path, refs: Sequence[ChannelRef], name: str) -> InputError:
    names = sorted({ref.layer or ref.full_name for ref in refs})
    near = get_close_matches(name, names, 1)
    hint = f"Did you mean {near[0]}?" if near else f"It has: {listed(names)}."
    return InputError(f"{path} has no layer or channel {name!r} to keep. {hint}")


def _is_called(ref: ChannelRef, name: str) -> bool:
    layer = ref.layer.lower()
    return name in (ref.full_name.lower(), ref.key.lower(), layer) or layer.startswith(f"{name}.")


def _id_attributes(headers: Sequence[Header]) -> dict[str, object]:
    """Return the Cryptomatte attributes, which name the objects in ID channels."""
    return {
        name: value
        for header in headers
        for name, value in header.items()
        if name.startswith(METADATA) and isinstance(value, str)
    }
