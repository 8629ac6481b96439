"""EXR files to plates. Every way the library has of failing ends in an InputError here."""

import os
from collections.abc import Sequence
from pathlib import Path

import OpenEXR

from heatlens.errors import InputError
from heatlens.image.channels import Header, Part
from heatlens.image.quiet import quiet_library
from heatlens.image.windows import box_at_header
from heatlens.paths import unreadable

# No GPU takes a larger texture; a damaged header can claim any size.
MAX_SIDE_PX = 16384

_HOLDS_DEEP = 1 << 11

# The library decompresses on one thread unless told; more than four gain nothing on a frame.
OpenEXR.set_global_thread_count(min(4, os.cpu_count() or 1))


def read_parts(path: str | os.PathLike[str]) -> list[Part]:
    """Header and channels, by their names in the part, of every part of the file.

    Raises InputError for what is no EXR file, is damaged, cut short or larger than a GPU takes.
    """
    path = Path(path)
    _check_is_exr(path)
    try:
        with quiet_library():
            headers = [part.header for part in OpenEXR.File(str(path), header_only=True).parts]
            _check_headers(path, headers)
            # Of damaged pixels the library only warns, in print, and drops the part.
            parts = OpenEXR.File(str(path), separate_channels=True).parts
        read = [(p.header, {n: c.pixels for n, c in p.channels.items()}) for p in parts]
    except (RuntimeError, ValueError, KeyError, TypeError, OSError, MemoryError) as error:
        _check_is_flat(path)
        raise InputError(
            f"{path} cannot be read: it is damaged or cut short, or uses a feature of OpenEXR that "
            f"heatlens does not know ({error}). Write it again."
        ) from error
    if len(read) != len(headers):
        lost, count = len(headers) - len(read), len(headers)
        whose = "its pixels" if count == 1 else f"the pixels of {lost} of its {count} parts"
        raise InputError(f"{path} is damaged or cut short: {whose} cannot be read. Write it again.")
    return read


def _check_is_exr(path: Path) -> None:
    """InputError for a path that is missing, no file, not readable or of another format."""
    try:
        with path.open("rb") as file:
            magic = file.read(4)
    except OSError as error:
        raise unreadable(path, error) from error
    if magic != b"\x76\x2f\x31\x01":
        found = "is empty" if not magic else "is not an OpenEXR file"
        raise InputError(f"{path} {found}: heatlens reads .exr files with colour and depth.")


def _check_is_flat(path: Path) -> None:
    """InputError for a deep file, which the library may not even open.

    Bit 11 of the second word says that some part is deep. Source: "OpenEXR File Layout".
    """
    with path.open("rb") as file:
        start = file.read(8)
    if len(start) == 8 and int.from_bytes(start[4:], "little") & _HOLDS_DEEP:
        raise InputError(
            f"{path} holds deep samples, which heatlens does not read: flatten it first."
        )


def _check_headers(path: Path, headers: Sequence[Header]) -> None:
    """InputError for no part at all, or a data window that no GPU takes or is empty."""
    if not headers:
        raise InputError(f"{path} is damaged: it has no readable part. Write it again.")
    for header in headers:
        window = box_at_header(header, "dataWindow")
        if not (0 < window.width <= MAX_SIDE_PX and 0 < window.height <= MAX_SIDE_PX):
            raise InputError(
                f"{path} has a data window of {window.width} x {window.height} pixels; heatlens "
                f"takes 1 to {MAX_SIDE_PX} a side."
            )
