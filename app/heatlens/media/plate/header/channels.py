"""List the channels of a file, each with its full name and the view that it belongs to.

The full name of a channel is `layer.leaf`. In a file of several parts, the name of the part serves
as the layer of channels that name none: `Z` in a part called `depth` is `depth.Z`.

A part with a single view of a stereo picture names it in the attribute `view`. A part with several
lists them in `multiView`; the view then stands before the last component of a channel's name, and
channels without a layer belong to the first view. Some programs only write left and right into the
names. Source: the OpenEXR documents "Storing Multi-View Images in OpenEXR Files" and "Standard
Attributes".
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.outside_text import join_first_names

Header = dict[str, Any]
Part = tuple[Header, dict[str, NDArray[np.generic]]]

_NAMES_MOST = 20
_EYES = ("left", "right")
_SEPARATORS = re.compile(r"[-._ ]")
_BEHIND = re.compile(r"behind(\.\d+)?$", re.IGNORECASE)


@dataclass(frozen=True)
class ChannelRef:
    """A channel.

    part       number of the part that holds it
    key        its name in the part
    full_name  `layer.leaf`
    view       the stereo view that it belongs to; "" for none
    """

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
    full_resolution = {
        (part, channel.name)
        for part, header in enumerate(headers)
        for channel in header["channels"]
        if channel.xSampling == channel.ySampling == 1 and not is_deep(header)
    }
    return tuple(ref for ref in list_channels(headers) if (ref.part, ref.key) in full_resolution)


def is_behind(part: Part) -> bool:
    """Return True if the name of a part marks hidden surfaces: behind, behind.1, ..."""
    return bool(_BEHIND.match(str(part[0].get("name", ""))))


def behind_layers(parts: Sequence[Part]) -> tuple[str, ...]:
    """Return the layers, of any part, that hold hidden surfaces, in the order of the file."""
    layers = dict.fromkeys(ref.layer for ref in list_channels([header for header, _ in parts]))
    return tuple(name for name in layers if _BEHIND.match(name))


def pixels_of(parts: Sequence[Part], ref: ChannelRef) -> NDArray[np.generic]:
    """Return the values (H, W) of a channel in the type of the file: float16, float32 or uint32."""
    pixels: NDArray[np.generic] = parts[ref.part][1][ref.key]
    return pixels


def join_names(names: Iterable[str]) -> str:
    """Return the first twenty names joined in one line."""
    return join_first_names([name or "(no name)" for name in names], _NAMES_MOST) or "nothing"


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


def _full_name(header: Header, key: str, has_many_parts: bool) -> str:
    """Return the full name, `layer.leaf`, of the channel `key`.

    In a file of several parts, the part's name is the layer of a channel that names none.
    """
    part_name = str(header.get("name", ""))
    if not has_many_parts or not part_name or key.lower().startswith(f"{part_name.lower()}."):
        return key
    plain_name = without_view(part_name, str(header.get("view", "")))
    if plain_name and key.lower().startswith(
        f"{plain_name.lower()}."
    ):  # Blender adds the view to the part
        return f"{part_name}{key[len(plain_name) :]}"
    return f"{part_name}.{key}"


def views_of(headers: Sequence[Mapping[str, object]]) -> tuple[str, ...]:
    """Return the views that the headers name, the default view first; () for fewer than two."""
    multi_views = [name for header in headers for name in _multi_view_names(header)]
    part_views = [str(header["view"]) for header in headers if header.get("view")]
    views = list(dict.fromkeys(multi_views or part_views))
    if not views:
        views = _eyes_in_names(headers)
    if not multi_views:  # the order of the parts means nothing
        views.sort(key=lambda name: name.lower() != _EYES[0])
    return tuple(views) if len(views) > 1 else ()


def view_of(header: Mapping[str, object], full_name: str, views: Sequence[str]) -> str:
    """Return the view of a channel; "" if it belongs to all views or there are none."""
    part_view = str(header.get("view", ""))
    multi_views = _multi_view_names(header)
    if part_view in views and len(multi_views) < 2:
        return part_view
    words = [word.lower() for word in _SEPARATORS.split(full_name)]
    view_in_name = next((view for view in views if view.lower() in words), "")
    if view_in_name or len(multi_views) < 2:
        return view_in_name
    return "" if "." in full_name else multi_views[0]


def without_view(name: str, view: str) -> str:
    """Return a name without the view's: `rgba_left` and `left.rgba` become `rgba`."""
    if not view:
        return name
    words = re.split(r"([-._ ])", name)  # words at even indices, separators between them
    kept_indices = [i for i in range(0, len(words), 2) if words[i].lower() != view.lower()]
    return "".join(words[i] + (words[i + 1] if i != kept_indices[-1] else "") for i in kept_indices)


def _multi_view_names(header: Mapping[str, object]) -> list[str]:
    """Return the names in `multiView`, which an older writer may have stored as another type."""
    value = header.get("multiView")
    return [str(name) for name in value] if isinstance(value, list | tuple) else []


def _eyes_in_names(headers: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return left and right if the names of parts or channels contain both."""
    names = [str(header.get("name", "")) for header in headers]
    names += [channel.name for header in headers for channel in header.get("channels", ())]
    words = {word.lower() for name in names for word in _SEPARATORS.split(name)}
    return list(_EYES) if set(_EYES) <= words else []
