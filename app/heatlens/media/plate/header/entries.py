"""Read the header entries that name programs, and choose the entries that output files keep.

pbrt writes no name, only two entries of its own; Octane, Karma and others write their names in
`Software`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.depth_words import DepthConvention
from heatlens.media.files.marks import BLURRED_ATTRIBUTE, JOB_ATTRIBUTE, YES
from heatlens.media.plate.header.channels import Header

# Header entry that is 1 for a display-referred picture, whose values are not scene light. It is
# copied to renders of that picture, so that they are viewed in the same way.
FOR_THE_EYE = "heatlens:forTheEye"
PICTURE_FACTS = (
    "heatlens:pictureFacts"  # header entry that holds a `PictureFacts`; never written to a file
)
FOCUS_POINT = "heatlens:photoFocus"  # parts of the width and height of the upright picture
# The writer writes these itself, or they describe parts, channels and layouts of the input alone.
_DROPPED_ATTRIBUTES = {
    *("channels", "compression", "dataWindow", "displayWindow", "lineOrder", "pixelAspectRatio"),
    *("type", "tiles", "chunkCount", "name", "version", "preview", "maxSamplesPerPixel"),
    *("multiView", "view", "dwaCompressionLevel", "zipCompressionLevel", "idManifest"),
    *("deepImageState", JOB_ATTRIBUTE, FOCUS_POINT, PICTURE_FACTS),
}
# Beginnings, in lower case, of entry names that only one program writes.
_PREFIXES = {
    "nuke/": "Nuke",
    "cycles.": "Blender",
    "blendermultichannel": "Blender",
    "arnold/": "Arnold",
    "vrayinfo": "V-Ray",
    "rstools": "Redshift",
    "rs/": "Redshift",
    "husk:": "Houdini",
    "husk_": "Houdini",
    "prman": "RenderMan",
    "rmanversion": "RenderMan",
    "rendertimeseconds": "pbrt",
}
# Entries in which programs write their name, and the words that identify them.
_ENTRIES = ("software", "generatedby", "generator", "writer", "creator", "renderer")
_WORDS = {
    "nuke": "Nuke",
    "blender": "Blender",
    "arnold": "Arnold",
    "v-ray": "V-Ray",
    "vray": "V-Ray",
    "mitsuba": "Mitsuba",
    "houdini": "Houdini",
    "karma": "Houdini",
    "husk": "Houdini",
    "mantra": "Houdini",
    "renderman": "RenderMan",
    "prman": "RenderMan",
    "redshift": "Redshift",
    "pbrt": "pbrt",
    "octane": "Octane",
    "3delight": "3Delight",
    "moonray": "MoonRay",
    "corona": "Corona",
}
# Programs that pass on the pictures of other programs.
_COMPOSITING_PROGRAMS = {"Nuke"}


def writing_program(headers: Sequence[Mapping[str, object]]) -> str:
    """Return the name of the program that wrote a file, or "" if it is unknown.

    If a compositing program passed on a render, it is returned instead of the renderer.
    """
    programs = _programs_in_headers(headers)
    return min(programs & _COMPOSITING_PROGRAMS or programs, default="")


def rendering_program(headers: Sequence[Mapping[str, object]]) -> str:
    """Return the name of the CG renderer that made the picture, or "" if none is named.

    A picture that a compositing program passed on still names its renderer.
    """
    return min(_programs_in_headers(headers) - _COMPOSITING_PROGRAMS, default="")


def _programs_in_headers(headers: Sequence[Mapping[str, object]]) -> set[str]:
    """Return every program that the headers name."""
    return {program for header in headers for program in _programs_in_header(header)}


def _programs_in_header(header: Mapping[str, object]) -> set[str]:
    """Return every program that one header names."""
    programs = set()
    for name, value in header.items():
        entry = name.lower()
        programs |= {program for prefix, program in _PREFIXES.items() if entry.startswith(prefix)}
        if entry in _ENTRIES and isinstance(value, str):
            text = value.lower()
            programs |= {program for word, program in _WORDS.items() if word in text}
    return programs


def is_blurred(header: Mapping[str, object]) -> bool:
    """Return whether the file is marked as one that went through a lens of heatlens."""
    return header.get(BLURRED_ATTRIBUTE) == YES


def blurred_notes(path: Path, header: Header, is_strict: bool = False) -> tuple[str, ...]:
    """Return a sentence if a lens of heatlens has blurred the picture, or may have.

    Raises InputError instead if it has and `is_strict` is set. The header of a file from an older
    version only marks an export, which may also be a pinhole plate.
    """
    if is_blurred(header):
        warning = (
            f"{path} is already blurred: heatlens rendered it through a lens, and another lens "
            "blurs it once more. Give the pinhole picture that it was made from"
        )
        if is_strict:
            raise InputError(f"{warning}, or leave --strict out.")
        return (f"{warning}.",)
    if JOB_ATTRIBUTE in header and BLURRED_ATTRIBUTE not in header:
        return (
            f"{path} was exported by an older heatlens, which did not tell whether through a lens: "
            "unless it is a pinhole plate, it is already blurred.",
        )
    return ()


@dataclass(frozen=True)
class PictureFacts:
    """Facts about a picture besides its pixels.

    notes       sentences about the color
    full_scale  value of white of a depth in integers, None for floating point
    convention  convention of the depth if the file states it, else None
    why         one sentence on how the convention is known
    """

    notes: tuple[str, ...] = ()
    full_scale: float | None = None
    convention: DepthConvention | None = None
    why: str = ""


def picture_facts(header: Header) -> PictureFacts | None:
    """Return the facts about a picture; None for a part of an EXR."""
    facts = header.get(PICTURE_FACTS)
    return facts if isinstance(facts, PictureFacts) else None


def notes_of(header: Header) -> tuple[str, ...]:
    """Return notes about the colors of a photo or picture; none for an EXR."""
    facts = picture_facts(header)
    return () if facts is None else facts.notes


def attributes_to_keep(header: Header) -> dict[str, object]:
    """Return the metadata worth keeping in the output."""
    return {
        name: value
        for name, value in header.items()
        if name not in _DROPPED_ATTRIBUTES and not name.startswith("cryptomatte/")
    }
