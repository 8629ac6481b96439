"""Read the parts of EXR files, and turn every failure of the library into an InputError."""

import os
from pathlib import Path

import OpenEXR

from heatlens.base.errors import InputError
from heatlens.files.quiet import quiet_library
from heatlens.plate.exr.deep_file import is_deep_file
from heatlens.plate.exr.exr_limits import check_exr, for_library
from heatlens.plate.header.channels import Part

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
            headers = [
                part.header for part in OpenEXR.File(for_library(path), header_only=True).parts
            ]
            # The library only prints a warning for damaged pixels, and drops the part.
            parts = OpenEXR.File(for_library(path), separate_channels=True).parts
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
