"""Read PFM, the portable float map of light stages and renderers, grey and coloured.

Pillow reads grey ones alone, and OpenImageIO gives coloured ones upside down: one reader for both
has the rows of all other pictures. Rows are stored from the bottom to the top. The sign of the
scale tells the order of bytes; its amount, a unit that nobody agreed on, is not used, as in Pillow.
Source: P. Debevec, "PFM Portable FloatMap Image Format".
"""

import re
from pathlib import Path

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import file_bytes
from heatlens.media.plate.plate import FloatImage

_HEAD = re.compile(rb"(P[Ff])\s+(\d{1,6})\s+(\d{1,6})\s+([-+.0-9eE]{1,32})\s")


def read_pfm(path: Path) -> FloatImage:
    """Return the values (H, W, 1 or 3), row 0 on top.

    Raises InputError for a file that is no PFM or is cut short, and OSError.
    """
    data = file_bytes(path)
    head = _HEAD.match(data)
    if head is None:
        raise InputError(f"{path} is not a PFM: its first words are not PF or Pf and its size.")
    width, height = int(head[2]), int(head[3])
    count = 3 if head[1] == b"PF" else 1
    have, need = len(data) - head.end(), 4 * width * height * count
    if have < need:
        raise InputError(f"{path} is cut short: {have} of {need} bytes of its pixels are there.")
    order = "<" if head[4].startswith(b"-") else ">"
    values = np.frombuffer(data, f"{order}f4", need // 4, head.end())
    rows: FloatImage = values.reshape(height, width, count)[::-1].astype(np.float32)
    return rows
