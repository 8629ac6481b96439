"""List the channels of a file, each with its full name and the view that it belongs to.

The full name of a channel is `layer.leaf`. In a file of several parts, the name of the part serves
as the layer of channels that name none: `Z` in a part called `depth` is `depth.Z`.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatlens.plate.header.views import view_of, views_of, without_view

Header = dict[str, Any]
Part = tuple[Header, dict[str, NDArray[np.generic]]]

_NAMES_LISTED = 20


@dataclass(frozen=True)
class ChannelRef:
    """One channel: the part it is in, its name there, its full name, and its view, "" for none."""

    part: int
    key: str
    full_name: str
    view: str = ""

    @property
    def layer(self) -> str:
        """The full name without its last component; "" for none."""
        return self.full_name.rpartition(".")[0]

    @property
    def leaf(self) -> str:
        """The last component, which says what the channel is within its layer."""
        return self.full_name.rpartition(".")[2]

    @property
    def plain_layer(self) -> str:
        """The layer without the name of the view."""
        return without_view(self.layer, self.view)


def type_name(header: Header) -> str:
    """Return the part's type in lower case: scanlineimage, tiledimage, deepscanline or deeptile."""
    return str(header.get("type", "scanlineimage")).rpartition(".")[2].lower()


def compression_name(header: Header) -> str:
    """Return the name of the compression as `--compression` takes it: none, zip, piz, dwaa ..."""
    name = str(header["compression"]).rpartition(".")[2].removesuffix("_COMPRESSION").lower()
    return "none" if name == "no" else name


def is_deep(header: Header) -> bool:
    """Return True for a part with many samples in a pixel."""
    return type_name(header).startswith("deep")


def list_channels(headers: Sequence[Header]) -> tuple[ChannelRef, ...]:
    """Return every channel, in the order of the file."""
    views, refs = views_of(headers), []
    for part, header in enumerate(headers):
        for channel in header["channels"]:
            full_name = _full_name(header, channel.name, len(headers) > 1)
            view = view_of(header, full_name, views)
            refs.append(ChannelRef(part, channel.name, full_name, view))
    return tuple(refs)


def flat_channels(headers: Sequence[Header]) -> tuple[ChannelRef, ...]:
    """Return the channels with exactly one value in every pixel: neither deep nor subsampled."""
    sampled = {
        (part, channel.name)
        for part, header in enumerate(headers)
        for channel in header["channels"]
        if channel.xSampling == channel.ySampling == 1 and not is_deep(header)
    }
    return tuple(ref for ref in list_channels(headers) if (ref.part, ref.key) in sampled)


def pixels_of(parts: Sequence[Part], ref: ChannelRef) -> NDArray[np.generic]:
    """Return the channel's values (H, W), float16, float32 or uint32 as in the file."""
    pixels: NDArray[np.generic] = parts[ref.part][1][ref.key]
    return pixels


def listed(names: Iterable[str]) -> str:
    """Return the first twenty names joined in one line."""
    all_names = [name or "(no name)" for name in names]
    left = len(all_names) - _NAMES_LISTED
    more = f" and {left} more" if left > 0 else ""
    return ", ".join(all_names[:_NAMES_LISTED]) + more if all_names else "nothing"


def unusable_sentence(headers: Sequence[Header]) -> str:
    """Return a sentence about deep or subsampled channels, "" if there are none."""
    if any(is_deep(header) for header in headers):
        return (
            " It holds deep samples, which heatlens can read only as the plate itself: flatten "
            "it first."
        )
    if any(c.xSampling != 1 or c.ySampling != 1 for h in headers for c in h["channels"]):
        return " Subsampled channels are not read: write them at full resolution."
    return ""


def _full_name(header: Header, key: str, many_parts: bool) -> str:
    """Return `layer.leaf`; the part's name serves as the layer of a channel that names none."""
    part_name = str(header.get("name", ""))
    if not many_parts or not part_name or key.lower().startswith(f"{part_name.lower()}."):
        return key
    plain = without_view(part_name, str(header.get("view", "")))
    if plain and key.lower().startswith(f"{plain.lower()}."):  # Blender adds the view to the part
        return f"{part_name}{key[len(plain) :]}"
    return f"{part_name}.{key}"
