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
    join_names,
    pixels_of,
)
from heatlens.media.plate.mattes.cryptomatte import METADATA
from heatlens.media.plate.parts.header_read import read_headers
from heatlens.media.plate.plate import Plate
from heatlens.media.plate.read import color_file_parts
from heatlens.media.plate.windows import move_to_window, read_header_window

ALL = "all"


def read_kept_channels(
    plate: Plate, options: PlateOptions, requested_names: Sequence[str]
) -> tuple[dict[str, NDArray[np.generic]], dict[str, Any]]:
    """Return pixels (H, W) by full name over the plate's data window, and attributes they need.

    `requested_names` are names of layers or channels, or "all". The color is never included,
    because it is rendered. Raises InputError for a name that the file does not have.
    """
    if not requested_names:
        return {}, {}
    parts = color_file_parts(plate.path, options)
    headers = [header for header, _ in parts]
    refs = _select_channels(plate.path, headers, options, requested_names)
    pixels_by_name: dict[str, NDArray[np.generic]] = {}
    for ref in refs:
        source = read_header_window(headers[ref.part], "dataWindow")
        pixels = pixels_of(parts, ref)
        if source != plate.data_window:
            pixels = move_to_window(pixels, source, plate.data_window, 0.0)
        pixels_by_name[ref.full_name] = pixels
    return pixels_by_name, _id_attributes(headers) if pixels_by_name else {}


def check_kept_channels(path: Path, options: PlateOptions, requested_names: Sequence[str]) -> None:
    """Raise InputError for all that `read_kept_channels` would refuse, without reading pixels."""
    if is_picture(path):
        raise InputError(f"{path} is not an EXR file: it has no other channels to keep.")
    if is_deep_file(path):
        raise InputError(
            f"{path} is a deep file: its other channels have several values in a pixel, which "
            "cannot be kept beside a picture. Leave --keep-channels out."
        )
    _select_channels(path, read_headers(path), options, requested_names)


def _select_channels(
    path: Path, headers: Sequence[Header], options: PlateOptions, requested_names: Sequence[str]
) -> list[ChannelRef]:
    """Return the requested layers and channels, in the order of the file."""
    color = choose_color(path, headers, options.color_layer, options.eye)
    refs = [ref for ref in flat_channels(headers) if ref not in (*color.rgb, color.alpha)]
    if ALL in requested_names:
        return refs
    selected: set[ChannelRef] = set()
    for name in requested_names:
        matches = [ref for ref in refs if _matches_name(ref, name.lower())]
        if not matches:
            raise _unknown_name_error(path, refs, name)
        selected.update(matches)
    return [ref for ref in refs if ref in selected]


def _unknown_name_error(path: Path, refs: Sequence[ChannelRef], name: str) -> InputError:
    """Return the error for a name that no layer or channel has, with the closest name."""
    names = sorted({ref.layer or ref.full_name for ref in refs})
    closest = get_close_matches(name, names, 1)
    hint = f"Did you mean {closest[0]}?" if closest else f"It has: {join_names(names)}."
    return InputError(f"{path} has no layer or channel {name!r} to keep. {hint}")


def _matches_name(ref: ChannelRef, name: str) -> bool:
    """Return True if a lower-case name is that of the channel, its layer or a layer above."""
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
