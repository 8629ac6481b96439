"""Film backs by name: the size that the sensor or the film gate gives the picture.

Sizes are of the largest recorded area (open gate) in millimeters. Their sources:
  film      camera apertures in the American Cinematographer Manual and SMPTE standards
  cameras   the makers' technical data sheets
  programs  the defaults of a new camera, so that default renders match without asking
"""

import difflib
import math
from dataclasses import dataclass

from heatlens.core.base.errors import InputError


@dataclass(frozen=True, slots=True)
class Filmback:
    """Width and height of the sensor or film gate in millimeters, and the source of the size."""

    name: str
    width_mm: float
    height_mm: float
    source: str

    def __post_init__(self) -> None:
        if not (0 < self.width_mm < math.inf and 0 < self.height_mm < math.inf):
            raise InputError(
                f"Film back {self.name!r}: width and height must be above 0 mm, got "
                f"{self.width_mm:g} x {self.height_mm:g} mm."
            )


FILMBACKS = (
    Filmback("Super 8", 5.79, 4.01, "SMPTE 157"),
    Filmback("16 mm", 10.26, 7.49, "SMPTE 7"),
    Filmback("Super 16", 12.52, 7.41, "SMPTE 201, type W"),
    Filmback("Academy 35", 22.05, 16.03, "SMPTE 59, style A: 0.868 x 0.631 in"),
    Filmback("Anamorphic 35", 22.05, 18.67, "SMPTE 59, style B: 0.868 x 0.735 in"),
    Filmback("Super 35", 24.89, 18.66, "SMPTE 59, style C: 0.980 x 0.735 in, 4 perforations"),
    Filmback("Super 35 3-perf", 24.89, 13.87, "0.980 x 0.546 in, 3 perforations"),
    Filmback("VistaVision", 37.72, 25.17, "1.485 x 0.991 in, 8 perforations"),
    Filmback("65 mm 5-perf", 52.63, 23.01, "SMPTE 215: 2.072 x 0.906 in"),
    Filmback("IMAX 70 mm", 70.41, 52.63, "2.772 x 2.072 in, 15 perforations of 65 mm negative"),
    Filmback("Full frame", 36.0, 24.0, "ISO 1007: the 135 still picture"),
    Filmback("APS-C", 23.5, 15.6, "Fujifilm, Nikon and Sony"),
    Filmback("APS-C Canon", 22.3, 14.9, "Canon"),
    Filmback("Micro Four Thirds", 17.3, 13.0, "Micro Four Thirds standard"),
    Filmback("ARRI Alexa Mini", 28.25, 18.17, "ARRI: 3424 x 2202, open gate"),
    Filmback("ARRI Alexa 35", 27.99, 19.22, "ARRI: 4608 x 3164, open gate"),
    Filmback("ARRI Alexa LF", 36.70, 25.54, "ARRI: 4448 x 3096, open gate"),
    Filmback("ARRI Alexa Mini LF", 36.70, 25.54, "ARRI: 4448 x 3096, open gate"),
    Filmback("ARRI Alexa 65", 54.12, 25.58, "ARRI: 6560 x 3100, open gate"),
    Filmback("RED Komodo 6K", 27.03, 14.26, "RED: 6144 x 3240"),
    Filmback("RED Helium 8K S35", 29.90, 15.77, "RED: 8192 x 4320"),
    Filmback("RED Monstro 8K VV", 40.96, 21.60, "RED: 8192 x 4320"),
    Filmback("RED V-Raptor 8K VV", 40.96, 21.60, "RED: 8192 x 4320"),
    Filmback("Sony Venice 6K FF", 36.2, 24.1, "Sony: 6048 x 4032, 3:2"),
    Filmback("Sony Venice 2 8K FF", 35.9, 24.0, "Sony: 8640 x 5760, 3:2"),
    Filmback("Blackmagic Pocket 4K", 18.96, 10.0, "Blackmagic Design: 4096 x 2160"),
    Filmback("Blackmagic Pocket 6K", 23.10, 12.99, "Blackmagic Design: 6144 x 3456"),
    Filmback("Blackmagic URSA Mini Pro 12K", 27.03, 14.25, "Blackmagic Design: 12288 x 6480"),
    Filmback("Blackmagic URSA Cine 12K LF", 35.64, 23.32, "Blackmagic Design: 12288 x 8040"),
    Filmback("Blender", 36.0, 24.0, "default of a new camera"),
    Filmback("Houdini", 41.4214, 23.2995, "default of a new camera at 16:9"),
    Filmback("Nuke", 24.576, 18.672, "default of a Camera node"),
    Filmback("Unreal", 23.76, 13.365, "default of a Cine Camera, 16:9 Digital Film"),
    Filmback("USD", 20.955, 15.2908, "default of UsdGeomCamera: 0.825 x 0.602 in"),
)


def filmback_named(name: str) -> Filmback:
    """Return the film back with this name, ignoring case, spaces and punctuation.

    Raises InputError that lists the most similar names.
    """
    by_key = {_key(back.name): back for back in FILMBACKS}
    filmback = by_key.get(_key(name))
    if filmback is None:
        similar_names = _near_names(name)
        hint = (
            f"nearest are {', '.join(similar_names)}"
            if similar_names
            else f"known are {', '.join(back.name for back in FILMBACKS)}"
        )
        raise InputError(
            f"No film back is called {name!r}; {hint}. Its width in millimetres works too."
        )
    return filmback


def _near_names(name: str) -> list[str]:
    """Return names that contain what was typed, then names spelled alike; at most five."""
    by_key = {_key(back.name): back.name for back in FILMBACKS}
    key = _key(name)
    containing_keys = [known_key for known_key in by_key if key and key in known_key]
    similar_keys = difflib.get_close_matches(key, by_key, n=5, cutoff=0.6)
    return [by_key[known_key] for known_key in dict.fromkeys(containing_keys + similar_keys)][:5]


def _key(name: str) -> str:
    """Return letters and digits in lower case: Super-35, super35 and Super 35 are one name."""
    return "".join(letter for letter in name.casefold() if letter.isalnum())
