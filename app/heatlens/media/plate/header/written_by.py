"""Find which program wrote an EXR file, from the entries in its header.

pbrt leaves no name, only two entries of its own; Octane, Karma and others put theirs in `Software`.
"""

from collections.abc import Mapping, Sequence

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
_COMPOSITING = {"Nuke"}


def written_by(headers: Sequence[Mapping[str, object]]) -> str:
    """Return the name of the program that wrote a file, or "" if it is unknown.

    If a compositing program passed on a render, it is returned instead of the renderer.
    """
    found = _programs_in(headers)
    return min(found & _COMPOSITING or found, default="")


def rendered_by(headers: Sequence[Mapping[str, object]]) -> str:
    """Return the name of the CG renderer that made the picture, or "" if none is named.

    A picture that a compositing program passed on still names its renderer.
    """
    return min(_programs_in(headers) - _COMPOSITING, default="")


def _programs_in(headers: Sequence[Mapping[str, object]]) -> set[str]:
    return {program for header in headers for program in _programs_of(header)}


def _programs_of(header: Mapping[str, object]) -> set[str]:
    """Return every program that one header names."""
    found = set()
    for name, value in header.items():
        entry = name.lower()
        found |= {program for prefix, program in _PREFIXES.items() if entry.startswith(prefix)}
        if entry in _ENTRIES and isinstance(value, str):
            text = value.lower()
            found |= {program for word, program in _WORDS.items() if word in text}
    return found
