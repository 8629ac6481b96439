"""Which program wrote an EXR file, by the entries that it leaves in the header.

pbrt leaves no name but two entries of its own; Octane, Karma and others tell theirs in `Software`.
"""

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
    "rendertimeseconds": "pbrt",
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
    "3delight": "3Delight",
    "moonray": "MoonRay",
    "corona": "Corona",
}
# Programs that pass the pictures of others on.
_COMPOSITING = {"Nuke"}


def written_by(headers: Sequence[Mapping[str, Any]]) -> str:
    """Return the name of the program that wrote a file, or "" for an unknown one.

    A compositing program that passed a render on is named before the renderer.
    """
    found = _programs_in(headers)
    return min(found & _COMPOSITING or found, default="")


def rendered_by(headers: Sequence[Mapping[str, Any]]) -> str:
    """Return the name of the CG renderer whose picture it is, or "" where none is named.

    What a compositing program has passed on still names its renderer.
    """
    return min(_programs_in(headers) - _COMPOSITING, default="")


def _programs_in(headers: Sequence[Mapping[str, Any]]) -> set[str]:
    return {program for header in headers for program in _programs_of(header)}


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
