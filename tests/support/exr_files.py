"""Small EXR files for the tests, written by the OpenEXR library without code of heatlens."""

from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR

Channels = dict[str, np.ndarray[Any, Any]]
ZIP = OpenEXR.ZIP_COMPRESSION


def part_header(**attributes: Any) -> dict[str, Any]:
    """Return a scanline ZIP header with `attributes` added or replaced."""
    return {"compression": ZIP, "type": OpenEXR.scanlineimage, **attributes}


def write_file(path: Path, channels: Channels, **attributes: Any) -> Path:
    """Write a file of one part."""
    OpenEXR.File(part_header(**attributes), dict(channels)).write(str(path))
    return path


def tiled_header() -> dict[str, Any]:
    """Return the attributes that make a file tiled, 4 x 4."""
    tiles = OpenEXR.TileDescription()
    tiles.xSize, tiles.ySize = 4, 4
    return {"type": OpenEXR.tiledimage, "tiles": tiles}


def write_parts(path: Path, *parts: tuple[dict[str, Any], Channels]) -> Path:
    """Write several parts, each (header, channels); the header has at least a name."""
    OpenEXR.File([OpenEXR.Part(part_header(**h), dict(c)) for h, c in parts]).write(str(path))
    return path


def window(x0: int, y0: int, x1: int, y1: int) -> tuple[Any, Any]:
    """Return a half-open box in the closed form of the file."""
    return np.array([x0, y0], np.int32), np.array([x1 - 1, y1 - 1], np.int32)


def rgb(height: int = 6, width: int = 8, dtype: Any = np.float16) -> Channels:
    """Return channels R, G and B with three different ramps, exact in half floats."""
    ramp = np.arange(height * width).reshape(height, width)
    return {name: (ramp + 64 * i).astype(dtype) / 4 for i, name in enumerate("RGB")}


def distances(height: int = 6, width: int = 8) -> np.ndarray[Any, Any]:
    """Return depths (H, W) in metres from 2 m on, all different."""
    return 2 + np.arange(height * width, dtype=np.float32).reshape(height, width) / 4
