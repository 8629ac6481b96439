"""Find the color space of a plate: the user's choice, else the one in its header.

The window, `render` and `export` all use this, so that they treat a plate in the same way.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from heatlens.media.color.color_config import LINEAR_REC709, ColorConfig
from heatlens.media.plate.header.primaries import (
    ADOBE_RGB,
    AP0,
    AP1,
    P3_D65,
    REC709,
    REC2020,
    XYZ,
    HeaderPrimaries,
    Primaries,
    header_primaries,
)

# Names of the spaces in configs of ACES 2, ACES 1 and Blender; the identifier is tried first.
_NAMES: Mapping[Primaries, tuple[str, ...]] = {
    REC709: LINEAR_REC709,
    AP0: ("ACES2065-1", "lin_ap0", "ACES - ACES2065-1"),
    AP1: ("ACEScg", "lin_ap1", "ACES - ACEScg"),
    REC2020: ("Linear Rec.2020", "lin_rec2020", "Utility - Linear - Rec.2020"),
    P3_D65: ("Linear P3-D65", "lin_p3d65", "Utility - Linear - P3-D65", "Linear DCI-P3 D65"),
    ADOBE_RGB: ("Linear AdobeRGB", "lin_adobergb", "Utility - Linear - Adobe RGB"),
    XYZ: ("CIE XYZ-D65 - Scene-referred", "cie_xyz_d65_scene", "Linear CIE-XYZ D65"),
}


@dataclass(frozen=True)
class InputSpace:
    """The space of a plate.

    name              a space of the config, or of `plate.primaries` without a config
    origin            how it was chosen, for the user
    note              a sentence if the header names a space that is unknown; else ""
    source_primaries  the plate's own primaries, if a matrix must convert the light to `name`
    Light in primaries that no space of the config has is converted to linear Rec. 709 by a matrix.
    """

    name: str
    origin: str
    note: str = ""
    source_primaries: Primaries | None = (
        None  # the plate's primaries, if a matrix converts to `name`
    )


def input_space_of(
    config: ColorConfig | None, attributes: Mapping[str, object], chosen_space: str = ""
) -> InputSpace:
    """Return `chosen_space` if it is given, else that of a picture whose header has `attributes`.

    If `config` is None, the plain sRGB curve is used, which knows the primaries of
    `plate.primaries` by name. Raises InputError if the config has no default space.
    """
    if chosen_space:
        return InputSpace(chosen_space, "chosen")
    stated = header_primaries(attributes)
    space = None if stated is None else _stated_space(config, stated)
    if stated is not None and space is not None:
        return InputSpace(space, f"header, {stated.attribute}")
    if stated is not None and stated.primaries is not None:
        rec709 = REC709.name if config is None else config.find_space(*LINEAR_REC709)
        if rec709 is not None:
            origin = f"header, {stated.attribute}, by a matrix"
            return InputSpace(rec709, origin, source_primaries=stated.primaries)
    default_space = REC709.name if config is None else config.default_input_space
    if stated is None:
        return InputSpace(default_space, "the header names no other")
    return InputSpace(
        name=default_space,
        origin=f"no other for {stated.attribute}",
        note=_unknown_space_note(config, stated, default_space),
    )


def _stated_space(config: ColorConfig | None, stated: HeaderPrimaries) -> str | None:
    """Return the name in the config of the space that the header states, or None."""
    if config is None:
        return None if stated.known is None else stated.known.name
    if stated.known is None:
        # A studio's config may have its own names; chromaticities are not a name.
        return config.find_space(stated.value) if stated.attribute == "colorInteropID" else None
    return config.find_space(stated.known.interop_id, *_NAMES[stated.known])


def _unknown_space_note(
    config: ColorConfig | None, stated: HeaderPrimaries, default_space: str
) -> str:
    """Return a sentence on a header whose space is not in the config."""
    if stated.known is not None and config is not None:
        problem = f"{config.source} has no {stated.known.name}, which is the header's"
    else:
        problem = "heatlens knows no colour space with the header's"
    return (
        f"{problem} {stated.attribute} ({stated.value}): the plate is read as {default_space} "
        "until "
        "another input space is chosen."
    )
