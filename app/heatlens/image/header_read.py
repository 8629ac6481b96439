"""The headers of an EXR file without its pixels: a tenth of a millisecond a file."""

import os

import OpenEXR

from heatlens.errors import InputError
from heatlens.image.channels import Header
from heatlens.image.quiet import quiet_library


def read_headers(path: str | os.PathLike[str]) -> list[Header]:
    """The header of every part. Raises InputError for a file that is missing, damaged or no EXR."""
    try:
        with quiet_library():
            parts = OpenEXR.File(str(path), header_only=True).parts
        headers = [part.header for part in parts]
    except (RuntimeError, ValueError, TypeError, OSError, MemoryError, ArithmeticError) as error:
        raise InputError(
            f"The header of {path} cannot be read: it is missing, damaged or no OpenEXR file "
            f"({error})."
        ) from error
    if not headers:
        raise InputError(f"{path} is damaged: it has no readable part. Write it again.")
    return headers
