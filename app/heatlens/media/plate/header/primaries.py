"""Find the color space of an EXR file from the primaries or the name in its header.

The attributes come from the OpenEXR list of standard attributes, where `chromaticities` holds CIE
x and y of red, green, blue and white; the identifiers are those of the Color Interop Forum. By the
OpenEXR documentation, a header without such an attribute means Rec. 709.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_D65 = (0.3127, 0.3290)
_ACES_WHITE = (0.32168, 0.33767)

# Writers round to three or four digits. Any two of KNOWN differ by at least 0.03 in one number.
TOLERANCE = 0.002
_LEAST_AREA = 1e-3  # twice the area of the triangle of primaries; that of Rec. 709 is 0.22


@dataclass(frozen=True)
class Primaries:
    """A scene-linear space that is known by its primaries."""

    name: str
    interop_id: str
    chromaticities: tuple[float, ...]  # CIE x, y of red, green, blue and white


REC709 = Primaries(
    name="linear Rec.709",
    interop_id="lin_rec709_scene",
    chromaticities=(0.64, 0.33, 0.30, 0.60, 0.15, 0.06, *_D65),
)
AP0 = Primaries(
    "ACES2065-1", "lin_ap0_scene", (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, *_ACES_WHITE)
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
# Plain tristimulus values: equal values are only the white of the coordinates, not a visible white.
XYZ = Primaries("CIE XYZ", "lin_ciexyzd65_scene", (1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1 / 3, 1 / 3))
KNOWN = (REC709, AP0, AP1, REC2020, P3_D65, ADOBE_RGB, XYZ)

_MEANINGLESS_IDS = ("", "unknown", "data")


@dataclass(frozen=True)
class HeaderPrimaries:
    """The primaries that a header states, and by which attribute.

    `known` is None if they are none of KNOWN.
    """

    attribute: str
    value: str  # the value of the attribute as text for people
    known: Primaries | None
    primaries: Primaries | None = None  # unknown but valid primaries, from their numbers


def header_primaries(attributes: Mapping[str, object]) -> HeaderPrimaries | None:
    """Return the primaries that `attributes` of a part state; None if they state none.

    A name takes precedence over numbers, because a file may keep the chromaticities of its source.
    """
    return (
        _find_by_name(attributes) or _find_by_numbers(attributes) or _find_by_container(attributes)
    )


def _find_by_name(attributes: Mapping[str, object]) -> HeaderPrimaries | None:
    """Return the primaries that "colorInteropID" names, or None."""
    name = attributes.get("colorInteropID")
    if not isinstance(name, str) or name.strip() in _MEANINGLESS_IDS:
        return None
    named_primaries = next((known for known in KNOWN if known.interop_id == name.strip()), None)
    return HeaderPrimaries(attribute="colorInteropID", value=name.strip(), known=named_primaries)


def _find_by_numbers(attributes: Mapping[str, object]) -> HeaderPrimaries | None:
    """Return the primaries of "chromaticities": known ones, new ones, or text alone; else None."""
    values = np.asarray(attributes.get("chromaticities", ()))
    if values.shape != (8,) or values.dtype.kind not in "if":
        return None
    text = ", ".join(
        f"{name} {x:.4g} {y:.4g}"
        for name, (x, y) in zip(
            ("red", "green", "blue", "white"), values.reshape(4, 2), strict=True
        )
    )
    matching = next((known for known in KNOWN if _are_chromaticities_of(values, known)), None)
    if matching is not None or not _are_valid_chromaticities(values):
        return HeaderPrimaries(attribute="chromaticities", value=text, known=matching)
    header_space = Primaries("the header's primaries", "", tuple(float(value) for value in values))
    return HeaderPrimaries("chromaticities", text, known=None, primaries=header_space)


def _are_valid_chromaticities(values: NDArray[np.generic]) -> bool:
    """Return True for three primaries that span an area, and a white inside it."""
    red, green, blue, white = values.reshape(4, 2).astype(np.float64)
    if not np.isfinite(values).all() or white[1] <= 0:
        return False
    corners = np.stack([[*corner, 1.0] for corner in (red, green, blue)], axis=1)
    if abs(np.linalg.det(corners)) < _LEAST_AREA:
        return False
    white_shares = np.linalg.solve(corners, [*white, 1.0])
    return bool((white_shares > 0).all())


def _find_by_container(attributes: Mapping[str, object]) -> HeaderPrimaries | None:
    """Recognise SMPTE ST 2065-4: files with this flag hold ACES2065-1 and nothing else."""
    if attributes.get("acesImageContainerFlag") != 1:
        return None
    return HeaderPrimaries(attribute="acesImageContainerFlag", value="1", known=AP0)


def _are_chromaticities_of(values: NDArray[np.floating], known: Primaries) -> bool:
    """Return True if the chromaticities (8,) are those of `known` within TOLERANCE."""
    return bool(np.all(np.abs(values - known.chromaticities) <= TOLERANCE))
