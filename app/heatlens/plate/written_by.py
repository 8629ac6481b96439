"""Which program wrote an EXR file, by the entries that it leaves in the header."""

from collections.abc import Mapping, Sequence
from typing import Any

# How the names of entries begin that nobody else writes, in lower case.
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
}
# Entries in which programs tell their name, and the words by which they are known.
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
}


def written_by(headers: Sequence[Mapping[str, Any]]) -> str:
    """Return the name of the program that wrote a file, or "" for an unknown one.

    A compositing program that passed a render on is named before the renderer.
    """
    found = {program for header in headers for program in _programs_of(header)}
    if "Nuke" in found:
        return "Nuke"
    return min(found, default="")


def _programs_of(header: Mapping[str, Any]) -> set[str]:
    """Return every program that one header names."""
    found = set()
    for name, value in header.items():
        entry = name.lower()
        found |= {program for prefix, program in _PREFIXES.items() if entry.startswith(prefix)}
        if entry in _ENTRIES and isinstance(value, str):
            said = value.lower()
            found |= {program for word, program in _WORDS.items() if word in said}
    return found
