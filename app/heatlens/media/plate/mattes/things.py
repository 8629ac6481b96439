"""Whether a thing is in a sequence at all, for whoever names one.

A thing may be out of a frame, and some renderers name only the things in the picture. A name that
no frame of the sequence knows is a mistake, and is refused.
"""

from contextlib import suppress
from functools import lru_cache
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.mattes.mattes import UnknownThingError, matte_of, thing_in
from heatlens.media.plate.plate import FloatImage, Plate
from heatlens.media.sequence.names import NameForm, form_of
from heatlens.media.sequence.sequence import Stamp, find_sequence, stamp_of

PLANE_OF, NEAREST_OF = "plane:", "nearest:"  # before the thing of a flat depth
_Thing = tuple[Path, NameForm, str]  # of all frames with names of one form in a folder
_seen: set[_Thing] = set()  # those that were found once


def matte_in_frame(plate: Plate, text: str) -> FloatImage | None:
    """Return what `matte_of` does; None where the thing is in other frames of the sequence.

    Raises UnknownThingError where no frame has it.
    """
    try:
        return matte_of(plate, text)
    except UnknownThingError as error:
        _found_elsewhere(plate.path, text, error)
        return None


def require_thing(path: Path, text: str) -> None:
    """Raise UnknownThingError where no frame of the sequence of a file has a thing.

    Raises InputError as `matte_of` does.
    """
    try:
        thing_in(path, text)
    except UnknownThingError as error:
        _found_elsewhere(path, text, error)


def require_things(path: Path, options: PlateOptions) -> None:
    """Raise as `require_thing` does for each thing that the options name."""
    flat = options.flat_depth and bare_name(options.flat_depth)
    for text in filter(None, (flat, options.never_blur, options.only_blur)):
        require_thing(path, text)


def bare_name(text: str) -> str:
    """Return the thing of a flat depth, without the word that tells how flat it becomes."""
    return text.removeprefix(PLANE_OF).removeprefix(NEAREST_OF)


def _found_elsewhere(path: Path, text: str, error: UnknownThingError) -> None:
    """Raise the error unless another frame has the thing."""
    thing = path.parent, form_of(path.name)[0], text
    if thing in _seen:
        return
    sequence = find_sequence(path)
    files = tuple(sequence.path_at(frame) for frame in sequence.present)
    if not _is_in_any(files, tuple(stamp_of(file) for file in files), text):
        raise error
    _seen.add(thing)


@lru_cache(maxsize=64)
def _is_in_any(files: tuple[Path, ...], _stamps: tuple[Stamp | None, ...], text: str) -> bool:
    """Return True if one of the files has the thing; the stamps tell when they are new files."""
    for file in files:
        with suppress(InputError):  # a frame that cannot be read is told where it is used
            thing_in(file, text)
            return True
    return False
