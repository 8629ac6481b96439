"""Read the camera of a capture by Record3D: rgb/12.jpg, depth/12.exr and metadata.json beside them.

The file gives the matrix of the camera by columns, in pixels of `w` x `h`, and the frame rate.
"""

import json
from fractions import Fraction
from functools import lru_cache
from pathlib import Path
from typing import Any

from heatlens.plate.header.camera_header import lens_attributes

_FOLDER, _FILE = "rgb", "metadata.json"
_LONG_SIDE_MM = 36.0  # of the full frame, on which phones tell their focal lengths
_SAME_ASPECT = 0.02


def capture_info(path: Path, size: tuple[int, int]) -> dict[str, object]:
    """Return the header of the camera for a picture of a capture; a note if it cannot be used."""
    file = path.parent.parent / _FILE
    if path.parent.name.lower() != _FOLDER or not file.is_file():
        return {}
    try:
        return {"header": _header(_read(file, file.stat().st_mtime_ns), size)}
    except (OSError, ValueError, LookupError, TypeError, ArithmeticError, RecursionError) as error:
        return {"note": f"{file} does not tell the camera ({error!r}): its lens is assumed."}


@lru_cache(maxsize=4)  # all frames of a capture share one file
def _read(file: Path, changed_ns: int) -> dict[str, Any]:
    found = json.loads(file.read_text("utf-8"))
    return {name: found[name] for name in ("K", "w", "h", "fps") if name in found}


def _header(found: dict[str, Any], size: tuple[int, int]) -> dict[str, object]:
    across, width, height = float(found["K"][0]), float(found["w"]), float(found["h"])
    if not (0 < across < 1e6 and 0 < width < 1e6 and 0 < height < 1e6):
        raise ValueError(f"a focal length of {across:g} px in {width:g} x {height:g}")
    if abs(size[0] * height / (size[1] * width) - 1) > _SAME_ASPECT:
        raise ValueError(f"it is for {width:g} x {height:g} pixels")
    mm = _LONG_SIDE_MM / max(width, height)
    lens = lens_attributes(across * mm, 1.0, 1.0, width * mm, height * mm)
    header = {name: lens[name] for name in ("pinholeFocalLength", "sensorOverallDimensions")}
    if 0 < float(found.get("fps", 0)) <= 10_000:
        header["framesPerSecond"] = Fraction(found["fps"]).limit_denominator(1001)
    return header
