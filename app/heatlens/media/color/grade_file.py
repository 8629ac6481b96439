"""Read a grade from a file of the ASC CDL: .cc, .ccc or .cdl."""

from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import ocio
from heatlens.core.base.paths import unreadable_error
from heatlens.core.model.shot.grade import Grade, parse_grade
from heatlens.media.color.color_config import error_text

GRADE_SUFFIXES = (".cc", ".ccc", ".cdl")


def parse_or_read_grade(text: str) -> Grade:
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
        raise unreadable_error(path)
    library.ClearAllCaches()  # else it returns the content of an earlier reading of this file
    try:
        transform = library.CDLTransform.CreateFromFile(str(path), identifier)
        return Grade(
            slope=tuple(transform.getSlope()),
            offset=tuple(transform.getOffset()),
            power=tuple(transform.getPower()),
            saturation=transform.getSat(),
        )
    except (library.Exception, library.ExceptionMissingFile) as error:
        id_note = f" with the ID {identifier!r}" if identifier else ""
        reason = error_text(error).rpartition("Error is: ")[2]
        raise InputError(f"{path} has no grade (ASC CDL){id_note} to read: {reason}") from error
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
