"""Read a grade from a file of the ASC CDL: .cc, .ccc or .cdl."""

from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import ocio
from heatlens.core.base.paths import unreadable
from heatlens.core.model.shot.grade import Grade, parse_grade
from heatlens.media.color.color_config import one_line

GRADE_SUFFIXES = (".cc", ".ccc", ".cdl")


def grade_named(text: str) -> Grade:
    """Return the grade of a file, of FILE#ID for one of several in it, or of a text of numbers.

    Raises InputError if it cannot be read.
    """
    name, _, identifier = text.partition("#")
    if Path(name).suffix.lower() in GRADE_SUFFIXES:
        return read_grade(Path(name), identifier)
    return parse_grade(text)


def read_grade(path: Path, identifier: str = "") -> Grade:
    """Return the grade with this ID in a file, or the first one. Raises InputError without one."""
    library = ocio()
    if not path.is_file():
        raise unreadable(path)
    library.ClearAllCaches()  # it would give what the file held when it was read before
    try:
        transform = library.CDLTransform.CreateFromFile(str(path), identifier)
        return Grade(
            tuple(transform.getSlope()),
            tuple(transform.getOffset()),
            tuple(transform.getPower()),
            transform.getSat(),
        )
    except (library.Exception, library.ExceptionMissingFile) as error:
        wanted = f" with the ID {identifier!r}" if identifier else ""
        reason = one_line(error).rpartition("Error is: ")[2]
        raise InputError(f"{path} has no grade (ASC CDL){wanted} to read: {reason}") from error
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
