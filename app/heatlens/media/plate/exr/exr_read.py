"""Read the parts of EXR files, and turn every failure of the library into an InputError.

Deep files are recognized here too, and the channels of a deep picture are chosen.
"""

import io
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, NamedTuple

import OpenEXR

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import open_regular_file, read_file_bytes
from heatlens.media.files.quiet import quiet_library
from heatlens.media.plate.exr.exr_scan import check_exr, scan_attributes
from heatlens.media.plate.header.channel_choice import ColorChoice, choose_color
from heatlens.media.plate.header.channels import (
    ChannelRef,
    Header,
    Part,
    is_deep,
    join_names,
    list_channels,
)

_DEEP_FLAG = 1 << 11  # of the second word of a file
_PICTURE = ("r", "g", "b", "a")  # leaf names that a deep picture must have
# OpenEXR for Python refuses a whole file with an attribute of one of these newer types, although it
# keeps attributes of types that it does not know at all. heatlens does not need them: they are
# replaced by texts of the same length with the name "~~~", which are then removed from the header.
_REFUSED_TYPES = ("deepImageState", "idmanifest")
_TEXT = b"string\0"
_HIDDEN_NAME = "~"  # the only letter in the names of such texts


@dataclass(frozen=True)
class DeepChannels:
    """The channels of a deep picture: color, alpha, and where samples begin and end.

    back  None if the file has no ZBack, so that its samples have no thickness
    """

    color: ColorChoice
    alpha: ChannelRef
    z: ChannelRef
    back: ChannelRef | None

    @property
    def part(self) -> int:
        """Number of the part of the file that holds them."""
        return self.z.part

    @property
    def names(self) -> tuple[str, ...]:
        """The names in the part: red, green, blue, alpha, Z, and ZBack where there is one."""
        refs = (*self.color.rgb, self.alpha, self.z, *([] if self.back is None else [self.back]))
        return tuple(ref.key for ref in refs)


def is_deep_file(path: Path) -> bool:
    """Return True for an EXR file with a deep part.

    Bit 11 of the second word says so. Source: "OpenEXR File Layout".
    """
    if not os.path.isfile(path):  # opening a pipe would wait for its writer
        return False
    try:
        with open_regular_file(path) as file:
            start = file.read(8)
    except OSError:  # the code that reads the file reports this with more detail
        return False
    is_exr = start[:4] == b"\x76\x2f\x31\x01" and len(start) == 8
    return is_exr and bool(int.from_bytes(start[4:], "little") & _DEEP_FLAG)


def choose_deep_channels(
    path: Path, headers: Sequence[Header], layer: str | None, eye: str | None
) -> DeepChannels:
    """Choose a layer with R, G, B, A and Z among the deep parts, as `choose_color` does.

    `layer` and `eye` are the user's choices, or None. Raises InputError that names the channels of
    the file if it has no such layer.
    """
    deep = [ref for ref in list_channels(headers) if is_deep(headers[ref.part])]
    complete = [ref for ref in deep if _has_deep_picture(deep, ref)]
    if not any(layer is None or layer.lower() == ref.layer.lower() for ref in complete):
        layer_words = "" if layer is None else f" in the layer {layer!r}"
        raise InputError(
            f"{path} is a deep file, and lacks some of R, G, B, A and Z{layer_words}. "
            f"It has {join_names(ref.full_name for ref in deep)}: write all five."
        )
    color = choose_color(path, headers, layer, eye, complete)
    by_leaf = {ref.leaf.lower(): ref for ref in _siblings(deep, color.rgb[0])}
    z = _find_depth(deep, color.rgb[0], "z")
    assert z is not None  # `_has_deep_picture` has checked it
    return DeepChannels(color, by_leaf["a"], z, _find_depth(deep, color.rgb[0], "zback"))


def _has_deep_picture(deep: Sequence[ChannelRef], ref: ChannelRef) -> bool:
    """Return True if the layer of a channel has R, G, B and A, and a Z of its own or shared."""
    leaves = {sibling.leaf.lower() for sibling in _siblings(deep, ref)}
    return leaves.issuperset(_PICTURE) and _find_depth(deep, ref, "z") is not None


def _siblings(deep: Sequence[ChannelRef], ref: ChannelRef) -> list[ChannelRef]:
    """Return the channels in the same part and layer as `ref`."""
    return [sibling for sibling in deep if (sibling.part, sibling.layer) == (ref.part, ref.layer)]


def _find_depth(deep: Sequence[ChannelRef], ref: ChannelRef, leaf: str) -> ChannelRef | None:
    """Return the channel `leaf`, z or zback, of the layer of `ref`, or else the shared one.

    All layers of a part can share a channel without a layer.
    """
    layer_channels = [sibling for sibling in _siblings(deep, ref) if sibling.leaf.lower() == leaf]
    shared_channels = [
        sibling for sibling in deep if sibling.part == ref.part and sibling.key.lower() == leaf
    ]
    return next(iter((*layer_channels, *shared_channels)), None)


# The library decompresses on one thread by default; more than four gain nothing on a frame.
OpenEXR.set_global_thread_count(min(4, os.cpu_count() or 1))


def read_parts(path: str | os.PathLike[str]) -> list[Part]:
    """Read all parts of a file: the header of each, and its channels by their names in the part.

    Raises InputError if it is not an EXR file, damaged, cut short or too large for a GPU.
    """
    path = Path(path)
    check_exr(path)
    try:
        with quiet_library():
            headers = [part.header for part in open_parts(path, header_only=True)]
            # For damaged pixels the library only prints a warning, and drops the part. Therefore
            # the counts of headers and of parts are compared below.
            parts = open_parts(path, separate_channels=True)
        part_list = [(p.header, {n: c.pixels for n, c in p.channels.items()}) for p in parts]
    except (RuntimeError, ValueError, KeyError, TypeError, OSError, MemoryError) as error:
        _check_is_flat(path)
        raise InputError(
            f"{path} cannot be read: it is damaged or cut short, or uses a feature of OpenEXR that "
            f"heatlens does not know ({error}). Write it again."
        ) from error
    if not headers:
        raise InputError(f"{path} is damaged: it has no readable part. Write it again.")
    if len(part_list) != len(headers):
        missing_count, count = len(headers) - len(part_list), len(headers)
        missing_words = (
            "its pixels" if count == 1 else f"the pixels of {missing_count} of its {count} parts"
        )
        raise InputError(
            f"{path} is damaged or cut short: {missing_words} cannot be read. Write it again."
        )
    return part_list


def _check_is_flat(path: Path) -> None:
    """Raise InputError for a deep file, which the library may be unable to open."""
    if is_deep_file(path):
        raise InputError(
            f"{path} holds deep samples, which heatlens can read only as the plate itself: "
            "flatten it first."
        )


class _AttributePosition(NamedTuple):
    """Offsets of an attribute in the file: its name, its type, and the first byte after it."""

    start: int
    type_start: int
    end: int


def open_parts(path: str | os.PathLike[str], **options: bool) -> list["OpenEXR.Part"]:
    """Return the parts of an EXR file as OpenEXR for Python opens it with these options."""
    parts: list[OpenEXR.Part] = OpenEXR.File(_library_source(path), **options).parts
    for part in parts:
        for name in [name for name in part.header if not name.strip(_HIDDEN_NAME)]:
            del part.header[name]
    return parts


def _library_source(path: str | os.PathLike[str]) -> str | io.BytesIO:
    """Return the name of a file for the library, or its content if the library needs that.

    The library opens no name that is not UTF-8, and refuses some attributes. For such files the
    content is returned, in which these attributes are replaced.
    """
    name = os.fspath(path)
    with open_regular_file(Path(path)) as file:
        refused_attributes = list(_find_refused(file))
    if os.fsencode(name) == name.encode("utf-8", "backslashreplace") and not refused_attributes:
        return name
    content = bytearray(read_file_bytes(Path(path)))
    for entry in refused_attributes:
        content[entry.start : entry.end] = _build_text_attribute(entry)
    return io.BytesIO(content)


def _find_refused(file: BinaryIO) -> Iterator[_AttributePosition]:
    """Yield the positions of the attributes that the library refuses."""
    for start, type_start, type_name, end in scan_attributes(file):
        if type_name in _REFUSED_TYPES:
            yield _AttributePosition(start, type_start, end)


def _build_text_attribute(entry: _AttributePosition) -> bytes:
    """Return an attribute of the same length that holds a text of spaces."""
    name = _HIDDEN_NAME.encode() * (entry.type_start - entry.start - 1) + b"\0"
    spaces = entry.end - entry.type_start - len(_TEXT) - 4
    return name + _TEXT + spaces.to_bytes(4, "little") + b" " * spaces
