"""Read where a photo was focused, and the f-stop that a phone simulated for its portrait.

Sources: the regions of the Metadata Working Group (mwg-rs, in XMP); SubjectArea of EXIF 2.32; the
entry SimulatedAperture that Apple writes in the XMP of the depth. libheif does not pass that one
on, so it is looked for in the file.
"""

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from heatlens.plate.coc_line import depth_at_m
from heatlens.plate.plate import Plate

FOCUS_POINT = "heatlens:photoFocus"  # parts of the width and height of the upright picture
_SUBJECT_AREA, _ORIENTATION = 0x9214, 0x0112
_REGION = re.compile(r"<rdf:li\b")
_IS_FOCUS = re.compile(r'mwg-rs:Type(?:="|>)Focus["<]')
_F_STOP = re.compile(rb'SimulatedAperture(?:="|>)\s*([\d.]{1,12})')
_F_STOPS = 0.5, 64.0
_SIDEWAYS = 5, 6, 7, 8
_WITH_F_STOP = (".heic", ".heif")


def portrait_header(
    path: Path, size: tuple[int, int], info: Mapping[str, Any]
) -> dict[str, object]:
    """Return header entries of a photo as Pillow opens it; empty if it tells nothing of this.

    `info` is that of `RawPicture`. HEIC has been turned upright already, JPEG has not.
    """
    found: dict[str, object] = {}
    tags, xmp = info["exif_tags"], info.get("xmp", b"")
    text = xmp.decode("utf-8", "replace") if isinstance(xmp, bytes) else ""
    turned = info.get("original_orientation")
    stored = size[::-1] if turned in _SIDEWAYS else size
    point = _region_of_focus(text) or _subject(tags, stored)
    if point is not None:
        found[FOCUS_POINT] = _upright(point, turned or tags.get(_ORIENTATION, 1))
    told = _F_STOP.search(path.read_bytes()) if path.suffix.lower() in _WITH_F_STOP else None
    f_stop = _number(told[1]) if told else None
    if f_stop is not None and _F_STOPS[0] <= f_stop <= _F_STOPS[1]:
        found["aperture"] = f_stop
    return found


def focused_as_taken(plate: Plate, header: Mapping[str, Any]) -> Plate:
    """Return the plate with its focus at what the photo was focused on, if that is known."""
    point, window = header.get(FOCUS_POINT), plate.display_window
    if point is None or not plate.has_distances or plate.camera.focus_distance_m is not None:
        return plate
    x, y = (
        min(int(p * n), n - 1) for p, n in zip(point, (window.width, window.height), strict=True)
    )
    focus_m = depth_at_m(plate, x, y)
    if not np.isfinite(focus_m):
        return plate
    sources = {**plate.camera.sources, "focus_distance_m": f"focus of the photo, pixel {x},{y}"}
    camera = replace(plate.camera, focus_distance_m=focus_m, sources=sources)
    return replace(plate, camera=camera)


def _region_of_focus(xmp: str) -> tuple[float, float] | None:
    """Return the middle of the first region of focus."""
    regions = (region for region in _REGION.split(xmp) if _IS_FOCUS.search(region))
    region = next(regions, "")
    found = (re.search(rf'stArea:{axis}(?:="|>)\s*([\d.]{{1,12}})', region) for axis in "xy")
    return _inside(*(None if one is None else _number(one[1].encode()) for one in found))


def _subject(tags: Mapping[int, Any], size: tuple[int, int]) -> tuple[float, float] | None:
    """Return the middle of the subject's area: a point, a circle or a rectangle around it."""
    area = tags.get(_SUBJECT_AREA)
    if not isinstance(area, tuple) or not 2 <= len(area) <= 4:
        return None
    if not all(isinstance(one, int) for one in area):
        return None
    return _inside(area[0] / size[0], area[1] / size[1])


def _inside(x: float | None, y: float | None) -> tuple[float, float] | None:
    if x is None or y is None or not (0 <= x <= 1 and 0 <= y <= 1):
        return None
    return x, y


def _upright(point: tuple[float, float], turn: object) -> tuple[float, float]:
    """Return the place in the upright picture of a place in the stored one; `turn` as in EXIF."""
    x, y = point
    places = {2: (1 - x, y), 3: (1 - x, 1 - y), 4: (x, 1 - y), 5: (y, x), 6: (1 - y, x)}
    places |= {7: (1 - y, 1 - x), 8: (y, 1 - x)}
    return places.get(turn, point) if isinstance(turn, int) else point


def _number(text: bytes) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
