"""What kind of source a name means, as far as the name tells; nothing is opened."""

from enum import StrEnum

from heatlens.scene.scene_name import names_scene

STREAM_PREFIX = "tev://"
NO_FILES = (
    "These frames come from a renderer and have no files: have it write an EXR, and open that."
)


class SourceKind(StrEnum):
    """The three kinds of sources."""

    PLATES = "plates"
    SCENE = "3D scene"
    STREAM = "stream"


def kind_of(text: str) -> SourceKind:
    """Return the kind that `text` names, as a shot file or a command line gives it."""
    if names_scene(text):
        return SourceKind.SCENE
    return SourceKind.STREAM if text.startswith(STREAM_PREFIX) else SourceKind.PLATES
