"""The kinds of sources: plates, 3D scenes and streams, each declared in one record.

Whatever differs between the kinds is a field of `SourceKind`, so a new kind is one more record in
`KINDS`; a field that it forgets fails to type-check.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import OnUse
from heatlens.media.files.picture_formats import suffixes_read
from heatlens.media.scene.scene_read import is_scene_name

if TYPE_CHECKING:  # they are imported on use, so that a command loads only what its source needs
    from heatlens.core.model.shot.framing import SceneTiming
    from heatlens.core.model.shot.plate_options import PlateOptions
    from heatlens.core.model.shot.shot import Shot
    from heatlens.media.camera.from_shot import CameraRequest
    from heatlens.media.camera.samples import CameraSamples
    from heatlens.render.source.opened import Opened, Opening
    from heatlens.render.source.source import Source

_PATTERN_MARKS = "#%@$"  # a name with one of these is a pattern of numbered files
STREAM_PREFIX = "tev://"  # how the name of a stream begins
NO_FILES = "These frames come from a renderer and have no files: write an EXR there and open that."


@dataclass(frozen=True)
class SourceKind:
    """One kind of source: everything that differs between kinds.

    word            returns the word for a source in lists of files, by its name
    article_word    what a sentence calls one of them: "a plate"
    matches         returns whether a name means a source of this kind
    has_camera      it has a camera that can move, with the options and panels for that
    reads_plates    its pictures are read from files, with the options for that
    refusal         the message about what it cannot do; "" if it can do everything

    make_source(text, options, timing)  return the source, which renders its frames any number of
                                   times
    make_single_source(path, options)  the same for one file, even if it belongs to a sequence
    open_source(opening)           open it with its first picture, on a thread
    camera(shot, request)          return the camera of a shot for other programs
    feed(picture, opened)          bring its pictures to the GPU for the window: a `PictureFeed`
    commands()                     read it on the command line: a `SourceCommands`
    python(name, asked)            open it in Python: a `heatlens.fronts.api.source.Source`

    The functions raise InputError with a message if the kind cannot do what they are for.
    """

    word: Callable[[str], str]
    article_word: str
    matches: Callable[[str], bool]
    has_camera: bool
    reads_plates: bool
    refusal: str
    make_source: Callable[[str, "PlateOptions", "SceneTiming | None"], "Source"]
    make_single_source: Callable[[Path, "PlateOptions"], "Source"]
    open_source: Callable[["Opening"], "Opened"]
    camera: Callable[["Shot", "CameraRequest"], "CameraSamples"]
    # The layers above define what these take and return.
    feed: Callable[[object, object], Any]
    commands: Callable[[], Any]
    python: Callable[[str, object], Any]


def refuse_source(text: str | Path, *_: object) -> Any:
    """Raise InputError: the frames of this source exist only once."""
    raise InputError(f"{text}: {kind_of(str(text)).refusal}")


def plates_word(text: str) -> str:
    """Return whether a name means one plate or a sequence, judged by the name alone."""
    name = Path(text).name
    is_file = name.lower().endswith(suffixes_read())
    return "Plate" if is_file and not any(mark in name for mark in _PATTERN_MARKS) else "Sequence"


SCENES = SourceKind(
    word=lambda _text: "3D scene",
    article_word="a 3D scene",
    matches=is_scene_name,
    has_camera=True,
    reads_plates=False,
    refusal="",
    make_source=OnUse("render.source.scene_source", "make_scene_source"),
    make_single_source=OnUse("render.source.scene_source", "make_single_scene_source"),
    open_source=OnUse("render.source.scene_source", "open_scene_source"),
    camera=OnUse("media.camera.from_shot", "camera_in_scene"),
    feed=OnUse("studio.session.opened.picture_feed", "SceneFeed"),
    commands=OnUse("fronts.commands.sources.of_scenes", "SceneCommands"),
    python=OnUse("fronts.api.opening", "open_scene"),
)
STREAMS = SourceKind(
    word=lambda _text: "Stream",
    article_word="a running renderer",
    matches=lambda text: text.startswith(STREAM_PREFIX),
    has_camera=False,
    reads_plates=True,
    refusal=NO_FILES,
    make_source=refuse_source,
    make_single_source=refuse_source,
    open_source=lambda opening: refuse_source(opening.text),
    camera=OnUse("media.camera.from_shot", "camera_before_plates"),
    feed=OnUse("studio.session.opened.picture_feed", "StreamFeed"),
    commands=OnUse("fronts.commands.sources.source_commands", "SourceCommands"),
    python=refuse_source,
)
PLATES = SourceKind(
    word=plates_word,
    article_word="a plate",
    matches=lambda _text: True,  # everything else
    has_camera=False,
    reads_plates=True,
    refusal="",
    make_source=OnUse("render.source.named", "make_plate_source"),
    make_single_source=OnUse("render.source.plate_source", "make_single_plate_source"),
    open_source=OnUse("render.source.opened_plates", "open_plates"),
    camera=OnUse("media.camera.from_shot", "camera_before_plates"),
    feed=OnUse("studio.session.opened.picture_feed", "PlateFeed"),
    commands=OnUse("fronts.commands.sources.of_plates", "PlateCommands"),
    python=OnUse("fronts.api.opening", "open_plates"),
)
# The first kind that takes a name is used.
KINDS: list[SourceKind] = [SCENES, STREAMS, PLATES]


def kind_of(text: str) -> SourceKind:
    """Return the kind of the source `text`, a name in a shot file or on a command line."""
    return next(kind for kind in KINDS if kind.matches(text))
