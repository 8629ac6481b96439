"""Write channels to an EXR file, completely or not at all."""

import io
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.media.files.atomic_file import write_atomically
from heatlens.media.files.quiet import quiet_library
from heatlens.media.plate.plate import FloatImage, Plate
from heatlens.media.plate.windows import make_header_window
from heatlens.media.sequence.names import parse_frame_name, parse_pattern

# Compressions that other programs read. All are lossless except the last two, which are lossy
# for half floats only.
COMPRESSIONS = ("none", "rle", "zips", "zip", "piz", "dwaa", "dwab")

_HALF_MAX = 65504.0
_FLOAT_LEAVES = ("z", "depth", "coc")  # channels that need more digits than a half float has


def write_exr(
    path: str | os.PathLike[str],
    channels: Mapping[str, NDArray[np.generic]],
    data_window: Box,
    display_window: Box,
    pixel_aspect_ratio: float = 1.0,
    attributes: Mapping[str, object] | None = None,
    half: bool = True,
    compression: str = "zip",
    unchanged: Mapping[str, NDArray[np.generic]] | None = None,
) -> None:
    """Write `channels` by name, each (H, W) over `data_window`, as half floats if `half`.

    Z, depth and coc stay float. The channels of `unchanged` are written in their own type: half,
    float or integers.

    Half values are clamped to +-65504, so that nothing bright becomes infinite. Attributes that
    the library cannot write (bytes, and in older versions rationals) are left out. Raises
    InputError, and leaves an existing file at `path` unchanged, if the file cannot be written or a
    channel has another size.
    """
    header = build_header(attributes or {}, data_window, display_window, pixel_aspect_ratio)
    header |= {"compression": _compression_constant(compression), "type": OpenEXR.scanlineimage}
    shape = (data_window.height, data_window.width)
    prepared = {
        name: _prepare_channel(name, values, shape, half) for name, values in channels.items()
    }
    kept_channels = {
        name: values for name, values in (unchanged or {}).items() if name not in prepared
    }
    prepared |= {name: np.ascontiguousarray(values) for name, values in kept_channels.items()}
    write_part(path, header, prepared)


def build_header(
    attributes: Mapping[str, object],
    data_window: Box,
    display_window: Box,
    pixel_aspect_ratio: float,
) -> dict[str, object]:
    """Return the header of a part: the attributes that the library can write, and the windows."""
    return writable_attributes(attributes) | {
        "dataWindow": make_header_window(data_window),
        "displayWindow": make_header_window(display_window),
        "pixelAspectRatio": float(pixel_aspect_ratio),
    }


def write_part(
    path: str | os.PathLike[str], header: Mapping[str, object], channels: Mapping[str, NDArray[Any]]
) -> None:
    """Write a file of one part, completely or not at all. Raises InputError if that fails."""
    encoded = io.BytesIO()  # on a full disk the library would silently write an incomplete file
    try:
        with quiet_library():
            OpenEXR.File(dict(header), dict(channels)).write(encoded)
    except RuntimeError as error:
        raise InputError(f"{path} could not be written: {error}.") from error
    write_atomically(path, encoded.getvalue())


def _prepare_channel(
    name: str, values: NDArray[np.generic], shape: tuple[int, int], half: bool
) -> NDArray[np.generic]:
    """Return `values` in the type and memory order of the file.

    Raises InputError if they do not have `shape`.

    The array must be contiguous: the library writes the memory of a view, not its elements.
    """
    if values.shape != shape:
        raise InputError(
            f"Channel {name!r} has {values.shape} values, but the data window needs {shape} "
            "(height, width)."
        )
    if half and name.rpartition(".")[2].lower() not in _FLOAT_LEAVES:
        return np.ascontiguousarray(np.clip(values, -_HALF_MAX, _HALF_MAX), dtype=np.float16)
    return np.ascontiguousarray(values, dtype=np.float32)


def _compression_constant(name: str) -> object:
    """Return the library's constant for one of COMPRESSIONS. Raises InputError."""
    if name not in COMPRESSIONS:
        raise InputError(f"No EXR compression {name!r}: choose one of {', '.join(COMPRESSIONS)}.")
    return getattr(OpenEXR, f"{'NO' if name == 'none' else name.upper()}_COMPRESSION")


def writable_attributes(attributes: Mapping[str, object]) -> dict[str, object]:
    """Return the attributes that the library can write, testing each in a file of one pixel.

    The library has no list of the types it can write, and a single bad attribute spoils the file.
    """
    return {name: value for name, value in attributes.items() if _can_write(name, value)}


def _can_write(name: str, value: object) -> bool:
    """Return True if a file with only this attribute can be written."""
    header = {"compression": OpenEXR.NO_COMPRESSION, "type": OpenEXR.scanlineimage, name: value}
    try:
        with quiet_library():
            OpenEXR.File(header, {"Y": np.zeros((1, 1), np.float16)}).write(io.BytesIO())
    except (RuntimeError, ValueError, TypeError):
        return False
    return True


def behind_path(pattern: Path, plate: Path) -> Path:
    """Return the file of hidden surfaces for a plate; a pattern takes the plate's frame number.

    Raises InputError for a name that is not an EXR, and where the plate has no number.
    """
    if pattern.suffix.lower() != ".exr":
        raise InputError(f"{pattern}: --behind-out writes an EXR file, because it has a depth.")
    notation, frame = parse_pattern(pattern.name), parse_frame_name(plate.name)[1]
    if notation is None:
        return pattern
    if frame is None:
        raise InputError(f"{plate} has no frame number for {pattern}: name one file.")
    return pattern.with_name(notation[0].name_at(frame))


def write_behind(path: Path, layers: Sequence[Plate]) -> None:
    """Write the nearest surfaces as R, G, B, A and Z, and the next ones as the layer `behind`.

    Raises InputError if there are none, or the file cannot be written.
    """
    if not layers:
        raise InputError(f"{path} is not written: no neighbouring frame shows a hidden surface.")
    channels: dict[str, FloatImage] = {}
    for layer, plate in zip(("", "behind."), layers, strict=False):
        assert plate.depth_m is not None
        channels |= {f"{layer}{name}": plate.color[..., index] for index, name in enumerate("RGBA")}
        channels[f"{layer}Z"] = plate.depth_m
    first = layers[0]
    windows = first.data_window, first.display_window
    write_exr(path, channels, *windows, first.pixel_aspect_ratio, first.attributes, half=False)
