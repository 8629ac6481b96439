"""Read PFM, the portable float map of light stages and renderers, gray and colored.

This reader replaces two others: Pillow reads only gray files, and OpenImageIO gives colored ones
upside down. Rows are stored from the bottom to the top. The sign of the scale is the order of
bytes; its amount, a unit that nobody agreed on, is not used, as in Pillow.
Source: P. Debevec, "PFM Portable FloatMap Image Format".
"""

import re
from pathlib import Path

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import read_file_bytes
from heatlens.media.plate.plate import FloatImage

_HEAD = re.compile(rb"(P[Ff])\s+(\d{1,6})\s+(\d{1,6})\s+([-+.0-9eE]{1,32})\s")


def read_pfm(path: Path) -> FloatImage:
    """Return the values (H, W, 1 or 3), row 0 on top.

    Raises InputError for a file that is no PFM or is cut short, and OSError.
    """
    data = read_file_bytes(path)
    head = _HEAD.match(data)
    if head is None:
        raise InputError(
            f"{path} is not a PFM, which begins with PF or Pf and its size: write it again."
        )
    width, height = int(head[2]), int(head[3])
    count = 3 if head[1] == b"PF" else 1
    pixel_bytes, needed_bytes = len(data) - head.end(), 4 * width * height * count
    if pixel_bytes < needed_bytes:
        raise InputError(
            f"{path} is cut short: {pixel_bytes} of {needed_bytes} bytes of its pixels are there. "
            "Write it again."
        )
    byte_order = "<" if head[4].startswith(b"-") else ">"
    values = np.frombuffer(data, f"{byte_order}f4", needed_bytes // 4, head.end())
    rows: FloatImage = values.reshape(height, width, count)[::-1].astype(np.float32)
    return rows
