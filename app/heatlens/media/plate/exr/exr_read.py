"""Read the parts of EXR files, and turn every failure of the library into an InputError.

Deep files are recognised, and the channels of their picture chosen.
"""

import io
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, NamedTuple

import OpenEXR

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import file_bytes, opened_file
from heatlens.media.files.quiet import quiet_library
from heatlens.media.plate.exr.exr_scan import attributes_of, check_exr
from heatlens.media.plate.header.channel_choice import ColorChoice, choose_color
from heatlens.media.plate.header.channels import (
    ChannelRef,
    Header,
    Part,
    is_deep,
    list_channels,
    listed,
)

_HOLDS_DEEP = 1 << 11
_PICTURE = ("r", "g", "b", "a")
# OpenEXR for Python knows the types of the first editions of the format, keeps those that it has
# never heard of, and refuses a whole file with one of a few that the format has got since. Nothing
# here needs these, so they are made into texts of the same length, whose names are signs alone,
# and are then left out of the header.
_REFUSED = ("deepImageState", "idmanifest")
_TEXT = b"string\0"
_LEFT_OUT = "~"  # a name of this sign alone


@dataclass(frozen=True)
class DeepChannels:
    """The channels of a deep picture: colour, alpha, and where samples begin and end.

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
        with opened_file(path) as file:
            start = file.read(8)
    except OSError:  # the code that reads the file reports this with more detail
        return False
    is_exr = start[:4] == b"\x76\x2f\x31\x01" and len(start) == 8
    return is_exr and bool(int.from_bytes(start[4:], "little") & _HOLDS_DEEP)


def deep_channels(
    path: Path, headers: Sequence[Header], layer: str | None, eye: str | None
) -> DeepChannels:
    """Choose a layer with R, G, B, A and Z among the deep parts, as `choose_color` does.

    Raises InputError that names what the file has.
    """
    deep = [ref for ref in list_channels(headers) if is_deep(headers[ref.part])]
    whole = [ref for ref in deep if _is_whole(deep, ref)]
    if not any(layer is None or layer.lower() == ref.layer.lower() for ref in whole):
        wanted = "" if layer is None else f" in the layer {layer!r}"
        raise InputError(
            f"{path} is a deep file, and has no R, G, B, A and Z{wanted}. "
            f"It has {listed(ref.full_name for ref in deep)}."
        )
    color = choose_color(path, headers, layer, eye, whole)
    own = {ref.leaf.lower(): ref for ref in _siblings(deep, color.rgb[0])}
    z = _depth_of(deep, color.rgb[0], "z")
    assert z is not None  # it is whole
    return DeepChannels(color, own["a"], z, _depth_of(deep, color.rgb[0], "zback"))


def _is_whole(deep: Sequence[ChannelRef], ref: ChannelRef) -> bool:
    leaves = {sibling.leaf.lower() for sibling in _siblings(deep, ref)}
    return leaves.issuperset(_PICTURE) and _depth_of(deep, ref, "z") is not None


def _siblings(deep: Sequence[ChannelRef], ref: ChannelRef) -> list[ChannelRef]:
    return [other for other in deep if (other.part, other.layer) == (ref.part, ref.layer)]


def _depth_of(deep: Sequence[ChannelRef], ref: ChannelRef, leaf: str) -> ChannelRef | None:
    """Return Z or ZBack of the layer, or the one that all layers of the part share."""
    own = [other for other in _siblings(deep, ref) if other.leaf.lower() == leaf]
    shared = [other for other in deep if other.part == ref.part and other.key.lower() == leaf]
    return next(iter((*own, *shared)), None)


# The library decompresses on one thread by default; more than four gain nothing on a frame.
OpenEXR.set_global_thread_count(min(4, os.cpu_count() or 1))


def read_parts(path: str | os.PathLike[str]) -> list[Part]:
    """Read the header and the channels, by their names in the part, of every part of a file.

    Raises InputError if it is not an EXR file, damaged, cut short or too large for a GPU.
    """
    path = Path(path)
    check_exr(path)
    try:
        with quiet_library():
            headers = [part.header for part in opened_parts(path, header_only=True)]
            # The library only prints a warning for damaged pixels, and drops the part.
            parts = opened_parts(path, separate_channels=True)
        read = [(p.header, {n: c.pixels for n, c in p.channels.items()}) for p in parts]
    except (RuntimeError, ValueError, KeyError, TypeError, OSError, MemoryError) as error:
        _check_is_flat(path)
        raise InputError(
            f"{path} cannot be read: it is damaged or cut short, or uses a feature of OpenEXR that "
            f"heatlens does not know ({error}). Write it again."
        ) from error
    if not headers:
        raise InputError(f"{path} is damaged: it has no readable part. Write it again.")
    if len(read) != len(headers):
        lost, count = len(headers) - len(read), len(headers)
        whose = "its pixels" if count == 1 else f"the pixels of {lost} of its {count} parts"
        raise InputError(f"{path} is damaged or cut short: {whose} cannot be read. Write it again.")
    return read


def _check_is_flat(path: Path) -> None:
    """Raise InputError for a deep file, which the library may be unable to open."""
    if is_deep_file(path):
        raise InputError(
            f"{path} holds deep samples, which heatlens can read only as the plate itself: "
            "flatten it first."
        )


class _Entry(NamedTuple):
    """Where an attribute lies in the file: its name, the rest, and the first byte after it."""

    start: int
    kind: int
    end: int


def opened_parts(path: str | os.PathLike[str], **how: bool) -> list["OpenEXR.Part"]:
    """Return the parts of an EXR file as OpenEXR for Python opens it; `how` are its options."""
    parts: list[OpenEXR.Part] = OpenEXR.File(_for_library(path), **how).parts
    for part in parts:
        for name in [name for name in part.header if not name.strip(_LEFT_OUT)]:
            del part.header[name]
    return parts


def _for_library(path: str | os.PathLike[str]) -> str | io.BytesIO:
    """Return the name of a file for the library, or its content where it takes only that.

    It takes no name that is not UTF-8, and no content with an attribute that it refuses.
    """
    name = os.fspath(path)
    with opened_file(Path(path)) as file:
        refused = list(_refused(file))
    if os.fsencode(name) == name.encode("utf-8", "backslashreplace") and not refused:
        return name
    content = bytearray(file_bytes(Path(path)))
    for entry in refused:
        content[entry.start : entry.end] = _as_text(entry)
    return io.BytesIO(content)


def _refused(file: BinaryIO) -> Iterator[_Entry]:
    for start, kind_at, kind, end in attributes_of(file):
        if kind in _REFUSED:
            yield _Entry(start, kind_at, end)


def _as_text(entry: _Entry) -> bytes:
    """Return an attribute of the same length that holds a text of spaces."""
    name = _LEFT_OUT.encode() * (entry.kind - entry.start - 1) + b"\0"
    spaces = entry.end - entry.kind - len(_TEXT) - 4
    return name + _TEXT + spaces.to_bytes(4, "little") + b" " * spaces
