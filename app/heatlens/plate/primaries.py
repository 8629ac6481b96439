"""What an EXR header tells of the colours' meaning: its primaries, and the name of their space.

Names of the attributes: the OpenEXR list of standard attributes, where `chromaticities` holds CIE
x and y of red, green, blue and white. Identifiers: the texture names of the Color Interop Forum.
A header that tells nothing means Rec. 709, says OpenEXR.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

_D65 = (0.3127, 0.3290)
_ACES_WHITE = (0.32168, 0.33767)

# Writers round to three or four digits. Any two of KNOWN differ by 0.03 somewhere.
TOLERANCE = 0.002
_LEAST_AREA = 1e-3  # of the triangle of primaries; Rec. 709's is 0.22 in the same measure


@dataclass(frozen=True)
class Primaries:
    """A scene-linear space that is known by its primaries."""

    name: str
    interop_id: str
    chromaticities: tuple[float, ...]  # CIE x, y of red, green, blue and white


REC709 = Primaries(
    "linear Rec.709", "lin_rec709_scene", (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, *_D65)
)
AP0 = Primaries(
    "ACES2065-1",
    "lin_ap0_scene",
    (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, *_ACES_WHITE),
)
AP1 = Primaries("ACEScg", "lin_ap1_scene", (0.713, 0.293, 0.165, 0.830, 0.128, 0.044, *_ACES_WHITE))
REC2020 = Primaries(
    "linear Rec.2020", "lin_rec2020_scene", (0.708, 0.292, 0.170, 0.797, 0.131, 0.046, *_D65)
)
P3_D65 = Primaries(
    "linear P3-D65", "lin_p3d65_scene", (0.680, 0.320, 0.265, 0.690, 0.150, 0.060, *_D65)
)
ADOBE_RGB = Primaries(
    "linear AdobeRGB", "lin_adobergb_scene", (0.64, 0.33, 0.21, 0.71, 0.15, 0.06, *_D65)
)
# Tristimulus values as they are: equal ones are no white to be seen, only that of the coordinates.
XYZ = Primaries("CIE XYZ", "lin_ciexyzd65_scene", (1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1 / 3, 1 / 3))
KNOWN = (REC709, AP0, AP1, REC2020, P3_D65, ADOBE_RGB, XYZ)

_TELLS_NOTHING = ("", "unknown", "data")


@dataclass(frozen=True)
class ToldPrimaries:
    """The primaries that a header states, and by which attribute.

    `known` is None where they are none of KNOWN.
    """

    attribute: str
    value: str  # as it stands there, for reading
    known: Primaries | None
    primaries: Primaries | None = None  # as the numbers say, where they can be light's


def told_primaries(attributes: Mapping[str, Any]) -> ToldPrimaries | None:
    """Return what `attributes` of a part state; None where they state nothing.

    A name wins over numbers: a file can keep the chromaticities of what it was made from.
    """
    return _by_name(attributes) or _by_numbers(attributes) or _by_container(attributes)


def _by_name(attributes: Mapping[str, Any]) -> ToldPrimaries | None:
    name = attributes.get("colorInteropID")
    if not isinstance(name, str) or name.strip() in _TELLS_NOTHING:
        return None
    found = next((known for known in KNOWN if known.interop_id == name.strip()), None)
    return ToldPrimaries("colorInteropID", name.strip(), found)


def _by_numbers(attributes: Mapping[str, Any]) -> ToldPrimaries | None:
    values = np.asarray(attributes.get("chromaticities", ()))
    if values.shape != (8,) or values.dtype.kind not in "if":
        return None
    said = ", ".join(
        f"{name} {x:.4g} {y:.4g}"
        for name, (x, y) in zip(
            ("red", "green", "blue", "white"), values.reshape(4, 2), strict=True
        )
    )
    found = next((known for known in KNOWN if _are_near(values, known)), None)
    if found is not None or not _can_be(values):
        return ToldPrimaries("chromaticities", said, found)
    own = Primaries("the header's primaries", "", tuple(float(value) for value in values))
    return ToldPrimaries("chromaticities", said, None, own)


def _can_be(values: np.ndarray[Any, Any]) -> bool:
    """Return True for three primaries that span an area, and a white inside it."""
    red, green, blue, white = values.reshape(4, 2).astype(np.float64)
    if not np.isfinite(values).all() or white[1] <= 0:
        return False
    corners = np.stack([[*corner, 1.0] for corner in (red, green, blue)], axis=1)
    if abs(np.linalg.det(corners)) < _LEAST_AREA:
        return False
    shares = np.linalg.solve(corners, [*white, 1.0])
    return bool((shares > 0).all())


def _by_container(attributes: Mapping[str, Any]) -> ToldPrimaries | None:
    """Recognise SMPTE ST 2065-4: files with this flag hold ACES2065-1 and nothing else."""
    if attributes.get("acesImageContainerFlag") != 1:
        return None
    return ToldPrimaries("acesImageContainerFlag", "1", AP0)


def _are_near(values: np.ndarray[Any, Any], known: Primaries) -> bool:
    return bool(np.all(np.abs(values - known.chromaticities) <= TOLERANCE))
