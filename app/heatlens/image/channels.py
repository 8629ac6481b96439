"""Which channels of a file are the colour and the depth: found by name, in a ranked order.

A channel is known by its full name, `layer.leaf`. In a file of several parts the part's name is the
layer of channels that name none, so `depth` / `Z` in a part of its own is `depth.Z`.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from heatlens.errors import InputError

Header = dict[str, Any]
Part = tuple[Header, dict[str, NDArray[Any]]]

# Layers that hold the finished picture, best first; "" is the layer without a name.
_COLOR_LAYERS = (
    *("", "rgba", "rgb", "combined", "beauty", "final", "main", "color", "colour", "c", "ci"),
    *("image", "left", "composite"),
)
# Layers whose channels are coordinates, directions or identities: neither light nor depth.
_DATA_LAYERS = (
    *("n", "normal", "normals", "p", "position", "pworld", "pref", "uv", "st", "motion", "vector"),
    *("velocity", "motionvector", "crypto", "cryptomatte", "objectid", "mist", "fog"),
)
# What a depth channel is called once case and punctuation are gone, best first.
_DEPTH_WORDS = (
    *("z", "depth", "zdepth", "lineardepth", "cameradepth", "pz", "vrayzdepth", "distance"),
    *("zfiltered", "disparity", "inversedepth", "inversez"),
)
_COC_WORDS = ("coc", "cocpx", "circleofconfusion")
# Leaves a renderer gives to the only channel of a layer, or to grey written three times.
_VALUE_LEAVES = ("", "z", "v", "y", "r", "x", "red", "value")
_LETTERS = {"r": "r", "red": "r", "g": "g", "green": "g", "b": "b", "blue": "b"}
_LETTERS |= {"a": "a", "alpha": "a"}


@dataclass(frozen=True)
class ChannelRef:
    """One channel: the part it is in, its name there and its full name."""

    part: int
    key: str
    full_name: str

    @property
    def layer(self) -> str:
        """All of the full name but the leaf; "" for none."""
        return self.full_name.rpartition(".")[0]

    @property
    def leaf(self) -> str:
        """The last component, which says what the channel is within its layer."""
        return self.full_name.rpartition(".")[2]


@dataclass(frozen=True)
class ColorChoice:
    """Red, green, blue (thrice the same for luminance) and alpha, with how they were chosen."""

    layer: str
    rgb: tuple[ChannelRef, ChannelRef, ChannelRef]
    alpha: ChannelRef | None
    notes: tuple[str, ...] = ()


def type_name(header: Header) -> str:
    """The part's type in lower case: scanlineimage, tiledimage, deepscanline or deeptile."""
    return str(header.get("type", "scanlineimage")).rpartition(".")[2].lower()


def is_deep(header: Header) -> bool:
    """True for a part with many samples in a pixel."""
    return type_name(header).startswith("deep")


def list_channels(headers: Sequence[Header]) -> tuple[ChannelRef, ...]:
    """Every channel of the file, in the order of the file."""
    return tuple(
        ChannelRef(part, channel.name, _full_name(header, channel.name, len(headers) > 1))
        for part, header in enumerate(headers)
        for channel in header["channels"]
    )


def pixels_of(parts: Sequence[Part], ref: ChannelRef) -> NDArray[Any]:
    """The channel's values (H, W), float16, float32 or uint32 as in the file."""
    pixels: NDArray[Any] = parts[ref.part][1][ref.key]
    return pixels


def choose_color(path: Path, headers: Sequence[Header], layer: str | None) -> ColorChoice:
    """The colour channels of `layer`, or of the likeliest layer when it is None.

    Raises InputError naming what was looked for and what the file has.
    """
    layers = _color_layers(_flat_channels(headers))
    if layer is not None:
        wanted = next((name for name in layers if name.lower() == layer.lower()), None)
        if wanted is None:
            raise InputError(
                f"{path} has no RGB layer {layer!r} for --color-layer; it has: {_listed(layers)}."
            )
        return _without_chroma(path, headers, layers[wanted])
    if not layers:
        raise InputError(_no_color_sentence(path, headers))
    chosen = min(layers.values(), key=lambda choice: _color_rank(choice, len(headers) > 1))
    return _without_chroma(path, headers, _with_guess_noted(chosen, layers))


def color_layers_among(names: Iterable[str]) -> tuple[str, ...]:
    """Those layers of channels, given by their full names, that `choose_color` could take."""
    return tuple(_color_layers([ChannelRef(0, name, name) for name in names]))


def depth_channels_first(names: Iterable[str]) -> tuple[str, ...]:
    """Channels by their full names, those whose names say depth before the others."""
    refs = [ChannelRef(0, name, name) for name in names]
    words = (*_DEPTH_WORDS, *_COC_WORDS)
    ranks = {ref.full_name: _depth_rank(ref, refs, words, "") for ref in refs}
    return tuple(sorted(ranks, key=lambda name: (ranks[name] is None, ranks[name] or 0)))


def choose_depth(
    path: Path, headers: Sequence[Header], name: str | None, color: ColorChoice | None, coc: bool
) -> ChannelRef:
    """The depth channel: `name`, or the likeliest one when it is None.

    `coc`: look for a circle of confusion before a depth. Among names equally good the one nearest
    to the colour wins (same layer tree, then same part). Raises InputError naming what was looked
    for and what the file has.
    """
    usable = _flat_channels(headers)
    if name is not None:
        return _named(path, usable, name)
    words = (*_COC_WORDS, *_DEPTH_WORDS) if coc else _DEPTH_WORDS
    layer, part = (color.layer, color.rgb[0].part) if color else ("", 0)
    ranked: list[tuple[int, bool, bool, int]] = []
    for index, ref in enumerate(usable):
        rank = _depth_rank(ref, usable, words, layer)
        if rank is not None:
            far = ref.full_name.partition(".")[0] != layer.partition(".")[0]
            ranked.append((rank, far, ref.part != part, index))
    if not ranked:
        raise InputError(_no_depth_sentence(path, headers))
    return usable[min(ranked)[-1]]


def _full_name(header: Header, key: str, many_parts: bool) -> str:
    """`layer.leaf`; the part's name stands for a layer that the channel does not name."""
    part_name = str(header.get("name", ""))
    if not many_parts or not part_name or key.lower().startswith(f"{part_name.lower()}."):
        return key
    return f"{part_name}.{key}"


def _flat_channels(headers: Sequence[Header]) -> tuple[ChannelRef, ...]:
    """The channels with exactly one value in every pixel: neither deep nor subsampled."""
    sampled = {
        (part, channel.name)
        for part, header in enumerate(headers)
        for channel in header["channels"]
        if channel.xSampling == channel.ySampling == 1 and not is_deep(header)
    }
    return tuple(ref for ref in list_channels(headers) if (ref.part, ref.key) in sampled)


def _color_layers(usable: Sequence[ChannelRef]) -> dict[str, ColorChoice]:
    """Every layer that can be shown, by name: red, green and blue, or luminance alone."""
    groups: dict[tuple[int, str], dict[str, ChannelRef]] = {}
    for ref in usable:
        letter = ref.leaf.lower()
        groups.setdefault((ref.part, ref.layer), {})[_LETTERS.get(letter, letter)] = ref
    layers: dict[str, ColorChoice] = {}
    for (_, layer), group in groups.items():
        if {"r", "g", "b"} <= group.keys():
            rgb = (group["r"], group["g"], group["b"])
        elif "y" in group and layer.rpartition(".")[2].lower() in _COLOR_LAYERS:
            rgb = (group["y"],) * 3
        else:
            continue
        layers.setdefault(layer, ColorChoice(layer, rgb, group.get("a")))
    return layers


def _color_rank(choice: ColorChoice, many_parts: bool) -> tuple[int, int]:
    """Lower is likelier to be the finished picture; ties keep the order of the file."""
    leaf = choice.layer.rpartition(".")[2].lower()
    if leaf in _COLOR_LAYERS:
        return _COLOR_LAYERS.index(leaf), choice.rgb[0].part
    is_data = leaf in _DATA_LAYERS or _squashed(leaf) in _DEPTH_WORDS
    first = 0 if many_parts and choice.rgb[0].part == 0 else 1
    return len(_COLOR_LAYERS) + first + 2 * is_data, choice.rgb[0].part


def _depth_rank(
    ref: ChannelRef, usable: Sequence[ChannelRef], words: Sequence[str], color_layer: str
) -> int | None:
    """Lower is likelier to be depth; None when the name does not say depth at all."""
    layer, leaf = ref.layer.rpartition(".")[2].lower(), ref.leaf.lower()
    if layer in _DATA_LAYERS:
        return None
    if _squashed(leaf) in words:
        siblings = {r.leaf.lower() for r in usable if (r.part, r.layer) == (ref.part, ref.layer)}
        if {"x", "y"} <= siblings and leaf == "z":
            return None  # the third axis of a vector
        known = layer in _COLOR_LAYERS or _squashed(layer) in words or ref.layer == color_layer
        return 2 * words.index(_squashed(leaf)) + (0 if known else 2 * len(words))
    if _squashed(layer) in words and leaf in _VALUE_LEAVES:
        return 2 * words.index(_squashed(layer)) + 1
    return None


def _named(path: Path, usable: Sequence[ChannelRef], name: str) -> ChannelRef:
    """The channel the user asked for: full name, name in its part, or layer of one channel."""
    for ref in usable:
        if name in (ref.full_name, ref.key):
            return ref
    wanted = name.lower()
    for ref in usable:
        if wanted in (ref.full_name.lower(), ref.key.lower()):
            return ref
    inside = [ref for ref in usable if ref.layer.lower() == wanted]
    if len(inside) == 1:
        return inside[0]
    raise InputError(
        f"{path} has no channel {name!r} for --depth-channel; it has: "
        f"{_listed(ref.full_name for ref in usable)}."
    )


def _squashed(name: str) -> str:
    """`name` in lower case without punctuation: Z_Depth, z-depth and zDepth are one word."""
    return "".join(letter for letter in name.lower() if letter.isalnum())


def _with_guess_noted(chosen: ColorChoice, layers: Mapping[str, ColorChoice]) -> ColorChoice:
    """`chosen`, with a sentence where its name does not say that it is the finished picture."""
    if chosen.layer.rpartition(".")[2].lower() in _COLOR_LAYERS or len(layers) == 1:
        return chosen
    note = (
        f"No layer is named like the finished picture: the colour is layer {chosen.layer!r}; "
        f"--color-layer takes another of {_listed(layers)}."
    )
    return replace(chosen, notes=(note,))


def _without_chroma(path: Path, headers: Sequence[Header], chosen: ColorChoice) -> ColorChoice:
    """`chosen`; InputError where it is the luminance of colours, which would come out grey."""
    keys = {ref.leaf.upper() for ref in list_channels(headers) if ref.part == chosen.rgb[0].part}
    if chosen.rgb[0] == chosen.rgb[1] and {"RY", "BY"} & keys:
        raise InputError(
            f"{path} stores luminance and subsampled chroma (Y, RY, BY), which heatlens does not "
            "read; write it as R, G, B."
        )
    return chosen


def _no_color_sentence(path: Path, headers: Sequence[Header]) -> str:
    """What was looked for, what there is, and why some of it does not count."""
    found = _listed(ref.full_name for ref in list_channels(headers))
    return (
        f"{path} has no colour: looked for channels R, G, B or Y, alone or in a layer; it has: "
        f"{found}.{_unusable_sentence(headers)}"
    )


def _no_depth_sentence(path: Path, headers: Sequence[Header]) -> str:
    """What was looked for, what there is, and the option that names it."""
    found = _listed(ref.full_name for ref in list_channels(headers))
    return (
        f"{path} has no depth channel: looked for Z, depth, depth.Z, zdepth, distance and the "
        f"like; it has: {found}.{_unusable_sentence(headers)} Render the depth into the file, or "
        "name its channel with --depth-channel."
    )


def _unusable_sentence(headers: Sequence[Header]) -> str:
    """Says so when deep or subsampled channels were passed over."""
    if any(is_deep(header) for header in headers):
        return " It holds deep samples, which heatlens does not read: flatten it first."
    if any(c.xSampling != 1 or c.ySampling != 1 for h in headers for c in h["channels"]):
        return " Subsampled channels are not read: write them at full resolution."
    return ""


def _listed(names: Iterable[str]) -> str:
    """The names in one line, the first twenty of them."""
    all_names = [name or "(no name)" for name in names]
    more = f" and {len(all_names) - 20} more" if len(all_names) > 20 else ""
    return ", ".join(all_names[:20]) + more if all_names else "nothing"
