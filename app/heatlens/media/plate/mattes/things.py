"""Check that a named thing is in some frame of a sequence.

A thing may be outside one frame, and some renderers name only the things in the picture. A name
that no frame of the sequence has is a mistake, and is refused.
"""

from contextlib import suppress
from functools import lru_cache
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.mattes.mattes import UnknownThingError, read_matte, read_thing_matte
from heatlens.media.plate.plate import FloatImage, Plate
from heatlens.media.sequence.names import NameForm, parse_frame_name
from heatlens.media.sequence.sequence import Stamp, stamp_of
from heatlens.media.sequence.sequence_search import find_sequence

PLANE_OF, NEAREST_OF = "plane:", "nearest:"  # prefixes of the thing of a flat depth
_Thing = tuple[Path, NameForm, str]  # folder and name form of a sequence, and the name of a thing
_known_things: set[_Thing] = set()  # things that were found in some frame of their sequence


def matte_in_frame(plate: Plate, text: str) -> FloatImage | None:
    """Return what `read_matte` does; None if the thing is only in other frames of the sequence.

    Raises UnknownThingError where no frame has it.
    """
    try:
        return read_matte(plate, text)
    except UnknownThingError as error:
        _require_in_sequence(plate.path, text, error)
        return None


def require_thing(path: Path, text: str) -> None:
    """Raise UnknownThingError if no frame of the sequence of a file has a thing.

    Raises InputError as `read_matte` does.
    """
    try:
        read_thing_matte(path, text)
    except UnknownThingError as error:
        _require_in_sequence(path, text, error)


def require_things(path: Path, options: PlateOptions) -> None:
    """Raise as `require_thing` does for each thing that the options name."""
    flat_thing = options.flat_depth and bare_name(options.flat_depth)
    for text in filter(None, (flat_thing, options.never_blur, options.only_blur)):
        require_thing(path, text)


def bare_name(text: str) -> str:
    """Return the thing of a flat depth, without the prefix `plane:` or `nearest:`."""
    return text.removeprefix(PLANE_OF).removeprefix(NEAREST_OF)


def _require_in_sequence(path: Path, text: str, error: UnknownThingError) -> None:
    """Raise the error unless another frame has the thing."""
    thing = path.parent, parse_frame_name(path.name)[0], text
    if thing in _known_things:
        return
    sequence = find_sequence(path)
    files = tuple(sequence.path_at(frame) for frame in sequence.present)
    if not _is_in_any(files, tuple(stamp_of(file) for file in files), text):
        raise error
    _known_things.add(thing)


@lru_cache(maxsize=64)
def _is_in_any(files: tuple[Path, ...], _stamps: tuple[Stamp | None, ...], text: str) -> bool:
    """Return True if one of the files has the thing; new stamps of files have it tested again."""
    for file in files:
        with suppress(InputError):  # a frame that cannot be read is reported where it is used
            read_thing_matte(file, text)
            return True
    return False
