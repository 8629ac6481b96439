"""Suggest options for names used in other programs and for other unknown names."""

from collections.abc import Iterable
from difflib import get_close_matches

OTHER_NAMES = {
    "aperture": "f-stop",
    "blende": "f-stop",
    "brennweite": "focal-length",
    "fnumber": "f-stop",
    "fstop": "f-stop",
    "iris": "f-stop",
    "camera": "scene-camera",
    "focus": "focus-distance",
    "fokus": "focus-distance",
    "lens": "focal-length",
    "out": "output",
    "resolution": "size",
    "samples": "views",
    "sensor": "sensor-width",
}


def or_meant(name: str, known: Iterable[str]) -> str:
    """Return " Did you mean X?" for a similar known name, ignoring case; "" if there is none."""
    by_small = {one.lower(): one for one in known}
    near = get_close_matches(name.lower(), by_small, 1)
    return f" Did you mean {by_small[near[0]]}?" if near else ""
