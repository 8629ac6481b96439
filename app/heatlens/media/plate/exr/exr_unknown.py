"""Open EXR files with attributes that OpenEXR for Python refuses as a whole.

It knows the types of the first editions of the format, keeps those that it has never heard of, and
refuses a file with one of a few that the format has got since. Nothing here needs these, so they
are made into texts of the same length, which are then left out of the header.
"""

import io
import os
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, NamedTuple

import OpenEXR

from heatlens.core.base.paths import file_bytes, opened_file
from heatlens.media.plate.exr.exr_scan import attributes_of

_REFUSED = ("deepImageState", "idmanifest")
_TEXT = b"string\0"
_LEFT_OUT = "~"  # a name of this sign alone


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
