"""Any channel of a file as a picture: normals, ids, the depth of another layer."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.header.channels import list_channels, pixels_of
from heatlens.media.plate.plate import FloatImage
from heatlens.media.plate.read import color_file_parts

_VECTORS = ("xyz", "rgb", "uvw")  # leaves that are shown together, as red, green and blue
_PERCENTILES = 1.0, 99.0  # of a number, from black to white
_HASH = np.uint64(0x9E3779B97F4A7C15)  # 2^64 / golden ratio: near ids get unlike colors


@dataclass(frozen=True, eq=False)
class ChannelPicture:
    """A channel, or the three of a vector.

    names   of the channels
    values  (H, W, count), as the file has them
    pixels  (H, W, 4), scene-linear, to look at
    """

    names: tuple[str, ...]
    values: NDArray[np.generic]
    pixels: FloatImage

    def words_at(self, row: int, column: int) -> str:
        """Return the values of a pixel with the names of their channels."""
        numbers = self.values[row, column].tolist()
        return "  ".join(
            f"{name} {value:.6g}" for name, value in zip(self.names, numbers, strict=True)
        )


def channel_choices(names: Iterable[str]) -> tuple[str, ...]:
    """Return what can be shown of these channels: a layer for a vector, else the channel."""
    return tuple(_grouped(tuple(names)))


def _grouped(names: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Return the channels by what is chosen to show them, in the order of the file."""
    groups: dict[str, tuple[str, ...]] = {}
    for name in names:
        layer, _, leaf = name.rpartition(".")
        vector = next((it for it in _VECTORS if leaf.lower() in tuple(it)), "")
        in_layer = {it.rpartition(".")[2].lower(): it for it in names if _is_in(layer, it)}
        members = tuple(in_layer[letter] for letter in vector if letter in in_layer)
        is_whole = bool(layer) and len(members) == len(_VECTORS[0])
        groups[layer if is_whole else name] = members if is_whole else (name,)
    return groups


def _is_in(layer: str, name: str) -> bool:
    return name.rpartition(".")[0] == layer


def read_channel(path: Path, choice: str) -> ChannelPicture:
    """Read what `choice` names of a file. Raises InputError where the file has no such channel."""
    parts = color_file_parts(path, PlateOptions())
    refs = {ref.full_name: ref for ref in list_channels([header for header, _ in parts])}
    names = _grouped(tuple(refs)).get(choice)
    if names is None:
        raise InputError(f"{path} has no channel {choice}.")
    values = np.stack([pixels_of(parts, refs[name]) for name in names], axis=-1)
    return ChannelPicture(names, values, _picture_of(choice, names, values))


def _picture_of(choice: str, names: Sequence[str], values: NDArray[np.generic]) -> FloatImage:
    """Return values as a picture: light as it is, directions around grey, ids in colors.

    Other numbers are stretched to what can be seen; a single channel becomes grey.
    """
    pixels = np.ones((*values.shape[:2], 4), np.float32)
    leaves = "".join(name[-1].lower() for name in names)
    is_id = values.dtype.kind in "ui" or choice.lower().endswith("id")
    if is_id and len(names) == 1:
        pixels[..., :3] = _colors_of_ids(values[..., 0])
    elif leaves == "rgb":
        pixels[..., :3] = np.nan_to_num(values.astype(np.float32), posinf=0.0, neginf=0.0)
    elif len(names) == 3 and np.nanmax(np.abs(values.astype(np.float32))) <= 1.0:
        pixels[..., :3] = 0.5 + 0.5 * np.nan_to_num(values.astype(np.float32))
    else:
        pixels[..., :3] = _stretched(values.astype(np.float32))
    return pixels


def _stretched(values: FloatImage) -> FloatImage:
    """Return each channel stretched from its low to its high percentile, to 0..1.

    What is not finite becomes as bright as the high one; a channel without a finite number is 0.
    """
    stretched = np.zeros_like(values)
    for index in range(values.shape[-1]):
        plane = values[..., index]
        is_finite = np.isfinite(plane)
        if is_finite.any():
            low, high = np.percentile(plane[is_finite], _PERCENTILES)
            span = max(float(high - low), 1e-12)
            stretched[..., index] = np.clip((np.where(is_finite, plane, high) - low) / span, 0, 1)
    return stretched


def _colors_of_ids(ids: NDArray[np.generic]) -> FloatImage:
    """Return a color for each id, the same wherever it stands; 0 is black."""
    hashed = ids.astype(np.float64).view(np.uint64) * _HASH
    bytes_of_hash = [(hashed >> np.uint64(shift)) & np.uint64(255) for shift in (56, 48, 40)]
    colors = np.stack(bytes_of_hash, axis=-1).astype(np.float32) / 255.0
    return np.where((ids == 0)[..., None], np.float32(0), 0.1 + 0.9 * colors)
