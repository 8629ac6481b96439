"""Read the camera of a picture in the folder of a capture, as apps for phones write it.

The pictures lie in `rgb`, and `metadata.json` beside that folder has the matrix K of the camera,
row by row in pixels, the size of the pictures, and the frame rate.
"""

import json
from fractions import Fraction
from functools import lru_cache
from pathlib import Path
from typing import Any

from heatlens.core.base.paths import read_file_bytes
from heatlens.media.plate.header.camera_header import lens_attributes

_FOLDER, _FILE = "rgb", "metadata.json"
_LONG_SIDE_MM = 36.0  # of the full frame, on which phones tell their focal lengths
_SAME_ASPECT = 0.02
_CAPTURE_MOST_BYTES = 256_000_000  # metadata.json of a capture holds the pose of each frame


def capture_info(path: Path, size: tuple[int, int]) -> dict[str, object]:
    """Return the header entries of the camera for a picture of a capture, {} for other pictures.

    If the capture does not describe its camera, a note says so instead.
    """
    file = path.parent.parent / _FILE
    if path.parent.name.lower() != _FOLDER or not file.is_file():
        return {}
    try:
        return {"header": _capture_header(_read_capture(file, file.stat().st_mtime_ns), size)}
    except (OSError, ValueError, LookupError, TypeError, ArithmeticError, RecursionError) as error:
        return {"note": f"{file} does not tell the camera ({error!r}): its lens is assumed."}


@lru_cache(maxsize=4)  # all frames of a capture share one file
def _read_capture(file: Path, changed_ns: int) -> dict[str, Any]:
    """Return the entries on the camera in a capture's file; another `changed_ns` reads it again."""
    capture = json.loads(read_file_bytes(file, _CAPTURE_MOST_BYTES).decode("utf-8"))
    return {name: capture[name] for name in ("K", "w", "h", "fps") if name in capture}


def _capture_header(capture: dict[str, Any], size: tuple[int, int]) -> dict[str, object]:
    """Return header entries with lens and frame rate for a picture (width, height) of a capture.

    Raises ValueError if the entries are impossible or belong to another size.
    """
    focal_px, width, height = float(capture["K"][0]), float(capture["w"]), float(capture["h"])
    if not (0 < focal_px < 1e6 and 0 < width < 1e6 and 0 < height < 1e6):
        raise ValueError(f"a focal length of {focal_px:g} px in {width:g} x {height:g}")
    if abs(size[0] * height / (size[1] * width) - 1) > _SAME_ASPECT:
        raise ValueError(f"it is for {width:g} x {height:g} pixels")
    mm_per_px = _LONG_SIDE_MM / max(width, height)
    lens = lens_attributes(focal_px * mm_per_px, 1.0, 1.0, width * mm_per_px, height * mm_per_px)
    header = {name: lens[name] for name in ("pinholeFocalLength", "sensorOverallDimensions")}
    if 0 < float(capture.get("fps", 0)) <= 10_000:
        header["framesPerSecond"] = Fraction(capture["fps"]).limit_denominator(1001)
    return header
