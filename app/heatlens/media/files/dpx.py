"""Write DPX with OpenImageIO, and read from its header what an export needs to know.

The numbers are display values, as in a PNG. The header states the transfer of video, Rec.709, which
is the nearest that DPX has, and not printing density.

Source: SMPTE ST 268-1:2014, table 1. Offsets and lengths below are those of the generic header.
"""

import struct
import tempfile
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import BinaryIO

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import import_extra
from heatlens.core.base.paths import open_regular_file, read_file_bytes
from heatlens.media.files.marks import marks_comment, parse_marks
from heatlens.media.files.picture_encoding import Stored
from heatlens.media.files.quiet import quiet_library

_ORDERS = {b"SDPX": ">", b"XPDS": "<"}
_FILE_SIZE, _HEADER_BYTES = 16, 2048
_FILE_NAME = slice(36, 136)
_PROJECT = slice(260, 460)  # text of up to 200 letters, which holds the marks
_WHITE = 1023


def require_openimageio() -> ModuleType:
    """Return OpenImageIO. Raises InputError if it is not installed."""
    return import_extra("OpenImageIO", "Writing DPX")


def dpx_bytes(values: Stored, marks: Mapping[str, str]) -> bytes:
    """Encode whole numbers of 10 bits (H, W, 3), with `marks` in the header.

    The marks (see marks.py) stand in the name of the project, the only free text that DPX has.
    """
    library = require_openimageio()
    height, width, channels = values.shape
    spec = library.ImageSpec(width, height, channels, library.UINT16)
    spec.attribute("oiio:BitsPerSample", 10)
    spec.attribute("dpx:Transfer", "ITU-R 709-4")
    spec.attribute("DocumentName", marks_comment(marks))  # OpenImageIO's name for the project
    scaled_values = np.round(values * (65535 / _WHITE)).astype(np.uint16)
    with tempfile.TemporaryDirectory() as folder, quiet_library():
        path = Path(folder) / "a.dpx"
        writer = library.ImageOutput.create("dpx")
        is_written = writer.open(str(path), spec) and writer.write_image(scaled_values)
        if not (writer.close() and is_written):
            raise InputError(
                f"A DPX cannot hold this picture ({writer.geterror()}): write EXR or PNG."
            )
        data = bytearray(read_file_bytes(path))
    data[_FILE_NAME] = bytes(_FILE_NAME.stop - _FILE_NAME.start)  # erase the temporary file's name
    return bytes(data)


def dpx_marks(path: Path) -> dict[str, str]:
    """Return the marks in the header of a DPX; raises ValueError if the header is cut short."""
    with open_regular_file(path) as file:
        header = file.read(_HEADER_BYTES)
    if len(header) < _HEADER_BYTES or header[:4] not in _ORDERS:
        raise ValueError(f"{path} is not a DPX")
    return parse_marks(header[_PROJECT].partition(b"\0")[0])


def is_complete_dpx(file: BinaryIO, size: int) -> bool:
    """Return True if the file is as long as its header says; `size` is its length in bytes."""
    header = file.read(_HEADER_BYTES)
    (length,) = struct.unpack_from(f"{_ORDERS[header[:4]]}I", header, _FILE_SIZE)
    return bool(length == size)
