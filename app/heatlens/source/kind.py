"""Tell the kind of a source from its name alone, without opening it."""

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
    """Return the kind of the source `text`, which stands in a shot file or a command line."""
    if names_scene(text):
        return SourceKind.SCENE
    return SourceKind.STREAM if text.startswith(STREAM_PREFIX) else SourceKind.PLATES
