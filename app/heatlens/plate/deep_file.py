"""Deep EXR files as they lie on disk: the samples of each pixel, read by OpenImageIO, an extra."""

import importlib
import importlib.util
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatlens.errors import InputError
from heatlens.files.quiet import quiet_library
from heatlens.model.boxes import Box
from heatlens.plate.exr_limits import check_exr
from heatlens.printable import one_line

SAMPLES_MOST = 50_000_000  # of a file: 1.2 GB as numbers
_HOLDS_DEEP = 1 << 11
_PIXELS_A_BAND = 1 << 16  # whose samples are ordinary Python numbers for a moment
_LEAVES = {"R": "r", "G": "g", "B": "b", "A": "a"}
_DEPTHS = {"Z": "z", "ZBack": "zback"}


@dataclass(frozen=True, eq=False)
class DeepSamples:
    """The samples of every pixel, those of one pixel after those of the pixel before.

    counts   (H * W,) samples of each pixel
    color    (N, 3) float32, premultiplied as in the file
    alpha    (N,) float32
    z, back  (N,) float32, where a sample begins and ends, in the unit of the file
    """

    counts: NDArray[np.int64]
    color: NDArray[np.float32]
    alpha: NDArray[np.float32]
    z: NDArray[np.float32]
    back: NDArray[np.float32]
    data_window: Box
    display_window: Box
    layer: str


def is_deep_file(path: Path) -> bool:
    """Return True for an EXR file with a deep part.

    Bit 11 of the second word says so. Source: "OpenEXR File Layout".
    """
    if not path.is_file():  # to open a pipe is to wait for whoever writes to it
        return False
    try:
        with path.open("rb") as file:
            start = file.read(8)
    except OSError:  # whoever reads the file says it better
        return False
    is_exr = start[:4] == b"\x76\x2f\x31\x01" and len(start) == 8
    return is_exr and bool(int.from_bytes(start[4:], "little") & _HOLDS_DEEP)


def read_deep_samples(path: Path, layer: str | None) -> DeepSamples:
    """Read the first deep part; `layer` None takes the first one with R, G, B, A and Z.

    Raises InputError for a damaged file, one without these channels or with too many samples, and
    where OpenImageIO is not installed.
    """
    check_exr(path)
    if importlib.util.find_spec("OpenImageIO") is None:
        raise InputError(
            f"{path} holds deep samples, which OpenImageIO reads: pip install 'heatlens[pictures]'."
        )
    library: Any = importlib.import_module("OpenImageIO")
    try:
        with quiet_library():
            return _read_by(library, path, layer)
    except (ValueError, RuntimeError, MemoryError) as error:  # names that are not UTF-8 among them
        raise InputError(f"{path} cannot be read: it is damaged ({error}).") from error


def _read_by(library: Any, path: Path, layer: str | None) -> DeepSamples:
    opened = library.ImageInput.open(str(path))
    if opened is None:
        raise InputError(f"{path} cannot be read: it is damaged ({one_line(library.geterror())}).")
    try:
        return _samples_of(path, opened, layer)
    finally:
        opened.close()


def _samples_of(path: Path, opened: Any, layer: str | None) -> DeepSamples:
    _seek_deep_part(path, opened)
    spec = opened.spec()
    layer, numbers = _channels(path, list(spec.channelnames), layer)
    deep = opened.read_native_deep_image(opened.current_subimage(), 0)
    if deep is None or deep.pixels != spec.width * spec.height:
        raise InputError(
            f"{path} is damaged or cut short ({one_line(opened.geterror())}). Write it again."
        )
    counts = np.fromiter(map(deep.samples, range(deep.pixels)), np.int64, deep.pixels)
    if counts.sum() > SAMPLES_MOST:
        raise InputError(
            f"{path} holds {counts.sum():,} samples; heatlens takes {SAMPLES_MOST:,}. Merge "
            "samples where it is written, or write a smaller picture."
        )
    values = _values(deep, counts, [numbers[leaf] for leaf in ("r", "g", "b", "a", "z")])
    back = values[:, 4]
    if "zback" in numbers:
        back = _values(deep, counts, [numbers["zback"]])[:, 0]
    x0, y0, full_x, full_y = spec.x, spec.y, spec.full_x, spec.full_y
    return DeepSamples(
        counts,
        np.ascontiguousarray(values[:, :3]),
        values[:, 3].copy(),
        values[:, 4].copy(),
        back.copy(),
        Box(x0, y0, x0 + spec.width, y0 + spec.height),
        Box(full_x, full_y, full_x + spec.full_width, full_y + spec.full_height),
        layer,
    )


def _seek_deep_part(path: Path, opened: Any) -> None:
    part = 0
    while not opened.spec().deep:
        part += 1
        if not opened.seek_subimage(part, 0):
            raise InputError(f"{path} has no deep part that can be read. Write it again.")


def _channels(path: Path, names: list[str], layer: str | None) -> tuple[str, dict[str, int]]:
    """Return the layer and where its channels are; Z may have no layer."""
    layers = [layer] if layer is not None else dict.fromkeys(n.rpartition(".")[0] for n in names)
    for candidate in layers:
        prefix = f"{candidate}." if candidate else ""
        found = _numbers(names, prefix, _LEAVES) | _numbers(names, "", _DEPTHS)
        found |= _numbers(names, prefix, _DEPTHS)
        if {"r", "g", "b", "a", "z"} <= found.keys():
            return candidate, found
    wanted = "" if layer is None else f" in the layer {layer!r}"
    raise InputError(
        f"{path} is a deep file, and has no R, G, B, A and Z{wanted}. It has {', '.join(names)}."
    )


def _numbers(names: list[str], prefix: str, leaves: dict[str, str]) -> dict[str, int]:
    """Return where the channels with these leaves are, by their short names."""
    there = {key: prefix + leaf for leaf, key in leaves.items() if prefix + leaf in names}
    return {key: names.index(name) for key, name in there.items()}


def _values(deep: Any, counts: NDArray[np.int64], channels: list[int]) -> NDArray[np.float32]:
    """Return the values of `channels`, (N, channels), band by band."""
    out = np.empty((int(counts.sum()), len(channels)), np.float32)
    done = 0
    for first in range(0, counts.size, _PIXELS_A_BAND):
        band = counts[first : first + _PIXELS_A_BAND]
        size = int(band.sum())
        pixels = np.repeat(np.arange(first, first + band.size), band)
        samples = np.arange(size) - np.repeat(np.cumsum(band) - band, band)
        of_pixel, of_sample = pixels.tolist(), samples.tolist()
        for column, channel in enumerate(channels):
            got = map(deep.deep_value, of_pixel, [channel] * size, of_sample)
            out[done : done + size, column] = np.fromiter(got, np.float32, size)
        done += size
    return out
