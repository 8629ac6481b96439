"""Choose the channels of a file that hold color and depth, by a ranking of their names."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.option import suggest_similar
from heatlens.media.files.picture_formats import is_picture
from heatlens.media.plate.header.channels import (
    ChannelRef,
    Header,
    flat_channels,
    join_names,
    list_channels,
    unusable_sentence,
    views_of,
)
from heatlens.media.plate.header.entries import writing_program

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
# Names of depth channels without case and punctuation, best first.
DEPTH_WORDS = (
    *("z", "depth", "zdepth", "lineardepth", "cameradepth", "pz", "vrayzdepth", "distance"),
    *("zfiltered", "disparity", "inversedepth", "inversez"),
    "dd",  # the names of depth in Mitsuba's manual: dd.y, dd.T
)
# In Mitsuba the distance along the ray is called T, whatever the layer.
_MITSUBA_WORDS = ("t",)
_COC_WORDS = ("coc", "cocpx", "circleofconfusion")
# Leaf names that renderers give to the only channel of a layer, or to gray written three times.
_VALUE_LEAVES = ("", "z", "v", "y", "r", "x", "red", "value", "t")
_LETTERS = {"r": "r", "red": "r", "g": "g", "green": "g", "b": "b", "blue": "b"}
_LETTERS |= {"a": "a", "alpha": "a"}


class NoDepthError(InputError):
    """A picture has no channel whose name says that it is a depth."""


@dataclass(frozen=True)
class ColorChoice:
    """The channels for red, green, blue and alpha; a luminance stands for all three colors.

    `notes` tell the user how they were chosen where that is not obvious.
    """

    layer: str
    rgb: tuple[ChannelRef, ChannelRef, ChannelRef]
    alpha: ChannelRef | None
    notes: tuple[str, ...] = ()

    @property
    def view(self) -> str:
        """The stereo view it belongs to, "" where the file has only one."""
        return self.rgb[0].view


def choose_color(
    path: Path,
    headers: Sequence[Header],
    layer: str | None,
    eye: str | None = None,
    candidates: Sequence[ChannelRef] | None = None,
) -> ColorChoice:
    """Choose the color channels of `layer`, or of the most likely layer if that is None.

    They are chosen from `candidates`, or from all flat channels if that is None. In a stereo file
    they belong to the view `eye`; if that is None, to the first view, and a note says so. Raises
    InputError that names what was looked for and what the file has.
    """
    views = views_of(headers)
    view = _find_view(path, views, eye)
    layers = _color_layers(flat_channels(headers) if candidates is None else candidates)
    if views and (eye is not None or layer is None):
        layers = _layers_of_view(layers, view or views[0])
    if layer is not None:
        layer_name = next((name for name in layers if name.lower() == layer.lower()), None)
        if layer_name is None:
            raise InputError(
                f"{path} has no RGB layer {layer!r} for --color-layer; it has: "
                f"{join_names(layers)}.{suggest_similar(layer, layers)}"
            )
        return _check_no_chroma(path, headers, layers[layer_name])
    if not layers:
        raise InputError(_no_color_sentence(path, headers))
    color = min(layers.values(), key=lambda choice: _color_rank(choice, len(headers) > 1))
    color = _check_no_chroma(path, headers, _add_guess_note(color, layers))
    return color if eye is not None else _add_views_note(path, color, views)


def color_layers_among(names: Iterable[str]) -> tuple[str, ...]:
    """Return the layers among full channel names that `choose_color` could take."""
    return tuple(_color_layers([ChannelRef(part=0, key=name, full_name=name) for name in names]))


def depth_channels_first(names: Iterable[str]) -> tuple[str, ...]:
    """Sort full channel names so that the most likely depth channels come first."""
    refs = [ChannelRef(part=0, key=name, full_name=name) for name in names]
    words = (*DEPTH_WORDS, *_COC_WORDS)
    ranks = {ref.full_name: _depth_rank(ref, refs, words, "") for ref in refs}
    return tuple(sorted(ranks, key=lambda name: (ranks[name] is None, ranks[name] or 0)))


def choose_depth(
    path: Path,
    headers: Sequence[Header],
    name: str | None,
    color: ColorChoice | None,
    prefers_coc: bool,
) -> ChannelRef:
    """Choose the depth channel: `name`, or the most likely one if that is None.

    With `prefers_coc`, a circle of confusion is preferred over a depth. The depth of another view
    than the color's is never chosen; among equally good names the one closest to the color wins
    (same layer tree, then same part). Raises InputError that names what was looked for and what the
    file has.
    """
    usable = flat_channels(headers)
    if name is not None:
        return _find_named(path, usable, name)
    words = (*_COC_WORDS, *DEPTH_WORDS) if prefers_coc else DEPTH_WORDS
    if writing_program(headers) == "Mitsuba":
        words = (*words, *_MITSUBA_WORDS)
    layer, part, view = (color.layer, color.rgb[0].part, color.view) if color else ("", 0, "")
    ranked: list[tuple[int, bool, bool, int]] = []
    for index, ref in enumerate(usable):
        is_other_view = bool(view) and ref.view not in ("", view)
        rank = None if is_other_view else _depth_rank(ref, usable, words, layer)
        if rank is not None:
            is_other_tree = ref.full_name.partition(".")[0] != layer.partition(".")[0]
            ranked.append((rank, is_other_tree, ref.part != part, index))
    if not ranked:
        raise NoDepthError(_no_depth_sentence(path, headers, view))
    return usable[min(ranked)[-1]]


def _find_view(path: Path, views: Sequence[str], eye: str | None) -> str | None:
    """Return the view named `eye`, ignoring case; raise InputError if there is none."""
    if eye is None:
        return None
    found_view = next((view for view in views if view.lower() == eye.lower()), None)
    if found_view is None:
        views_text = f"it has: {', '.join(views)}" if views else "it has one view, without a name"
        advice = f"{views_text}.{suggest_similar(eye, views)}"
        raise InputError(f"{path} has no view {eye!r} for --eye; {advice}")
    return found_view


def _layers_of_view(layers: Mapping[str, ColorChoice], view: str) -> dict[str, ColorChoice]:
    """Return the layers of a view, by name; if it has none, those that belong to all views."""
    view_layers = {name: choice for name, choice in layers.items() if choice.view == view}
    return view_layers or {name: choice for name, choice in layers.items() if not choice.view}


def _add_views_note(path: Path, choice: ColorChoice, views: Sequence[str]) -> ColorChoice:
    """Return `choice` with a note if the file has other views as well."""
    other_views = [view for view in views if view != choice.view]
    if not (choice.view and other_views):
        return choice
    note = (
        f"{path} holds the views {' and '.join(views)}: {choice.view} is taken; "
        f"--eye {other_views[0]} takes the other."
    )
    return replace(choice, notes=(*choice.notes, note))


def _color_layers(usable: Sequence[ChannelRef]) -> dict[str, ColorChoice]:
    """Return every layer that can be shown, by name: red, green and blue, or luminance alone."""
    groups: dict[tuple[int, str], dict[str, ChannelRef]] = {}
    for ref in usable:
        letter = ref.leaf.lower()
        groups.setdefault((ref.part, ref.layer), {})[_LETTERS.get(letter, letter)] = ref
    layers: dict[str, ColorChoice] = {}
    for (_, layer), group in groups.items():
        if {"r", "g", "b"} <= group.keys():
            rgb = (group["r"], group["g"], group["b"])
        elif "y" in group and _last_component(group["y"].plain_layer) in _COLOR_LAYERS:
            rgb = (group["y"],) * 3
        else:
            continue
        layers.setdefault(layer, ColorChoice(layer, rgb, group.get("a")))
    return layers


def _color_rank(choice: ColorChoice, has_many_parts: bool) -> tuple[int, int]:
    """Return a sort key: the lowest is the likeliest finished picture; ties keep file order."""
    leaf = _last_component(choice.rgb[0].plain_layer)
    if leaf in _COLOR_LAYERS:
        return _COLOR_LAYERS.index(leaf), choice.rgb[0].part
    is_data = leaf in _DATA_LAYERS or _strip_punctuation(leaf) in DEPTH_WORDS
    part_rank = 0 if has_many_parts and choice.rgb[0].part == 0 else 1
    return len(_COLOR_LAYERS) + part_rank + 2 * is_data, choice.rgb[0].part


def _depth_rank(
    ref: ChannelRef, usable: Sequence[ChannelRef], words: Sequence[str], color_layer: str
) -> int | None:
    """Return a rank: the lowest is most likely a depth; None if the name does not suggest one."""
    layer, leaf = _last_component(ref.plain_layer), ref.leaf.lower()
    if layer in _DATA_LAYERS:
        return None
    if _strip_punctuation(leaf) in words:
        siblings = {r.leaf.lower() for r in usable if (r.part, r.layer) == (ref.part, ref.layer)}
        if {"x", "y"} <= siblings and leaf == "z":
            return None  # the third axis of a vector
        is_color_layer = layer in _COLOR_LAYERS or ref.layer == color_layer
        is_known_layer = is_color_layer or _strip_punctuation(layer) in words
        return 2 * words.index(_strip_punctuation(leaf)) + (0 if is_known_layer else 2 * len(words))
    if _strip_punctuation(layer) in words and leaf in _VALUE_LEAVES:
        return 2 * words.index(_strip_punctuation(layer)) + 1
    return None


def _find_named(path: Path, usable: Sequence[ChannelRef], name: str) -> ChannelRef:
    """Find the channel that the user named.

    The name may be a full name, a name within a part, or a layer that holds a single channel.
    """
    for ref in usable:
        if name in (ref.full_name, ref.key):
            return ref
    name_lower = name.lower()
    for ref in usable:
        if name_lower in (ref.full_name.lower(), ref.key.lower()):
            return ref
    layer_channels = [ref for ref in usable if ref.layer.lower() == name_lower]
    if len(layer_channels) == 1:
        return layer_channels[0]
    raise InputError(
        f"{path} has no channel {name!r} for --depth-channel; it has: "
        f"{join_names(ref.full_name for ref in usable)}."
        f"{suggest_similar(name, (ref.full_name for ref in usable))}"
    )


def _last_component(layer: str) -> str:
    """Return the last component of a layer's name in lower case."""
    return layer.rpartition(".")[2].lower()


def _strip_punctuation(name: str) -> str:
    """Return the name in lower case without punctuation: Z_Depth, z-depth and zDepth are equal."""
    return "".join(letter for letter in name.lower() if letter.isalnum())


def _add_guess_note(choice: ColorChoice, layers: Mapping[str, ColorChoice]) -> ColorChoice:
    """Return `choice`, with a note if its name does not say that it is the finished picture."""
    if _last_component(choice.rgb[0].plain_layer) in _COLOR_LAYERS or len(layers) == 1:
        return choice
    note = (
        "No layer has a usual name for the finished picture: the colour is layer "
        f"{choice.layer!r}; --color-layer takes another of {join_names(layers)}."
    )
    return replace(choice, notes=(note,))


def _check_no_chroma(path: Path, headers: Sequence[Header], choice: ColorChoice) -> ColorChoice:
    """Return `choice`; raise InputError for a luminance whose chroma is in other channels."""
    keys = {ref.leaf.upper() for ref in list_channels(headers) if ref.part == choice.rgb[0].part}
    if choice.rgb[0] == choice.rgb[1] and {"RY", "BY"} & keys:
        raise InputError(
            f"{path} stores luminance and subsampled chroma (Y, RY, BY), which heatlens does not "
            "read; write it as R, G, B."
        )
    return choice


def _no_color_sentence(path: Path, headers: Sequence[Header]) -> str:
    """Return a sentence on the channels that were looked for, those found, and those of no use."""
    names = join_names(ref.full_name for ref in list_channels(headers))
    return (
        f"{path} has no colour: looked for channels R, G, B or Y, alone or in a layer; it has: "
        f"{names}.{unusable_sentence(headers)}"
    )


def _no_depth_sentence(path: Path, headers: Sequence[Header], view: str) -> str:
    """Return a sentence on the channels looked for, those found, and the option to name one."""
    if is_picture(path):
        return (
            f"{path} has no depth: name its file with --depth FILE or the half of the picture "
            "that holds it with --depth-side, or estimate it with --depth-model FILE.onnx."
        )
    names = join_names(ref.full_name for ref in list_channels(headers))
    of_view = f" of the view {view}" if view else ""
    return (
        f"{path} has no depth channel{of_view}, such as Z or depth.Z; it has: {names}."
        f"{unusable_sentence(headers)} Render the depth into the file, or name its channel with "
        "--depth-channel or its file with --depth FILE."
    )
