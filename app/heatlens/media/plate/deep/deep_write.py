"""Write a plate and the surfaces behind it to a deep EXR file, completely or not at all."""

import os
from collections.abc import Mapping

import numpy as np
import OpenEXR
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.media.plate.exr.exr_write import build_header, write_part
from heatlens.media.plate.fragments import FragmentLists
from heatlens.media.plate.plate import Plate

# The library needs an array object for each channel of each pixel.
_BYTES_A_PIXEL = 1500
_MOST_BYTES = 6_000_000_000
_CHANNELS = ("R", "G", "B", "A", "Z")


def write_deep(
    path: str | os.PathLike[str], plate: Plate, attributes: Mapping[str, object], half: bool = True
) -> None:
    """Write the plate with its fragment lists: R, G, B (times coverage), A, and Z in meters.

    Z always has 32 bits. Raises InputError, and leaves an existing file at `path` unchanged, if the
    plate is too large for this or the file cannot be written.
    """
    check_deep_fits(path, plate.data_window.width, plate.data_window.height)
    counts, samples = deep_samples(plate)
    windows = plate.data_window, plate.display_window
    header = build_header(attributes, *windows, plate.pixel_aspect_ratio)
    header |= {"compression": OpenEXR.ZIPS_COMPRESSION, "type": OpenEXR.deepscanline}
    channels = {
        name: _split_by_pixel(
            values.astype(np.float16 if half and name != "Z" else np.float32), counts
        )
        for name, values in zip(_CHANNELS, samples.T, strict=True)
    }
    shape = plate.data_window.shape
    write_part(path, header, {name: values.reshape(shape) for name, values in channels.items()})


def check_deep_fits(path: str | os.PathLike[str], width: int, height: int) -> None:
    """Raise InputError for a deep picture that takes too much memory to write."""
    needed_bytes = width * height * _BYTES_A_PIXEL
    if needed_bytes > _MOST_BYTES:
        fitting_side = int((_MOST_BYTES / _BYTES_A_PIXEL * width / height) ** 0.5)
        raise InputError(
            f"{path}: a deep picture of {width}x{height} takes about {needed_bytes / 1e9:.0f} GB "
            "of memory "
            f"to write. A --size of {fitting_side}x{fitting_side * height // width}, overscan "
            "included, fits."
        )


def deep_samples(plate: Plate) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Return the number of samples of each pixel (P,), and the samples (N, 5).

    A sample is premultiplied RGBA and Z in meters. The visible surface of a pixel comes first; it
    is added where the list does not begin with it.
    """
    assert plate.depth_m is not None
    pixels = plate.depth_m.size
    lists = plate.fragments or FragmentLists(
        np.zeros(pixels + 1, np.uint32), np.zeros((0, 3), np.uint32)
    )
    listed_counts, needs_front = np.diff(lists.begins), ~lists.has_front
    counts = listed_counts + needs_front
    first_sample = np.cumsum(counts) - counts
    samples = np.empty((int(counts.sum()), 5), np.float32)
    front_samples = first_sample[needs_front]
    samples[front_samples, :4] = plate.color.reshape(-1, 4)[needs_front]
    samples[front_samples, 4] = plate.depth_m.ravel()[needs_front]
    listed_pixel = np.repeat(np.arange(pixels), listed_counts)
    listed_samples = (
        first_sample[listed_pixel]
        + needs_front[listed_pixel]
        + np.arange(lists.count)[: len(listed_pixel)]
        - lists.begins[listed_pixel]
    )
    cover = lists.coverage[: len(listed_pixel), None].astype(np.float32)
    samples[listed_samples, :3] = lists.color[: len(listed_pixel)] * cover
    samples[listed_samples, 3:4] = cover
    with np.errstate(divide="ignore"):
        samples[listed_samples, 4] = np.float32(1.0) / lists.dioptres[: len(listed_pixel)]
    return counts, samples


def _split_by_pixel(values: NDArray[np.generic], counts: NDArray[np.int64]) -> NDArray[np.object_]:
    """Split `values` into an array of P arrays, one for each pixel."""
    lists = np.empty(len(counts), object)
    end = np.cumsum(counts)
    for i, (first, last) in enumerate(zip((end - counts).tolist(), end.tolist(), strict=True)):
        lists[i] = values[first:last]
    return lists
