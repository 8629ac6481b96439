"""What heatlens writes into its own files: what an export made, and whether it went through a lens.

An EXR holds each mark as an entry of its header, and a PNG as a text; JPEG, TIFF and movies have
one comment for both. Without these marks a picture could be blurred twice.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from heatlens.base.errors import InputError
from heatlens.plate.header.channels import Header

# What an exported frame was made of. It must not be copied to other files.
JOB_ATTRIBUTE = "heatlens:job"
# Whether a lens has been applied: _YES, or _NO for a pinhole plate.
BLURRED_ATTRIBUTE = "heatlens:blurred"
IMAGE_DESCRIPTION = 270  # the TIFF tag for a text

_YES, _NO = "yes", "no"
_MARKS = (JOB_ATTRIBUTE, BLURRED_ATTRIBUTE)


def blurred_mark(is_blurred: bool) -> dict[str, str]:
    """Return the mark of a picture that went through a lens, or of one that did not."""
    return {BLURRED_ATTRIBUTE: _YES if is_blurred else _NO}


def comment_of(marks: Mapping[str, str]) -> str:
    """Return the marks as one text, for files whose only text is a comment."""
    return " ".join(f"{name}={value}" for name, value in marks.items())


def marks_in(comment: object) -> dict[str, str]:
    """Return the marks in a comment; none for the comment of another program."""
    text = comment.decode("ascii", "replace") if isinstance(comment, bytes) else str(comment or "")
    words = (word.partition("=") for word in text.split())
    return {name: value for name, _, value in words if name in _MARKS}


def picture_marks(info: Mapping[str, Any], tags: Mapping[int, Any]) -> dict[str, str]:
    """Return the marks in the texts of a picture and its TIFF or EXIF tags, as Pillow has them."""
    comment = info.get("comment") or tags.get(IMAGE_DESCRIPTION)
    return marks_in(comment) | {name: str(info[name]) for name in _MARKS if name in info}


def is_blurred(header: Mapping[str, object]) -> bool:
    """Return whether the file is marked as one that went through a lens of heatlens."""
    return header.get(BLURRED_ATTRIBUTE) == _YES


def blurred_notes(path: Path, header: Header, is_strict: bool = False) -> tuple[str, ...]:
    """Return a sentence if a lens of heatlens has blurred the picture, or may have.

    Raises InputError instead if it has, and `is_strict`. Exports of older versions tell only that
    they are exports, which pinhole plates are too.
    """
    if is_blurred(header):
        told = (
            f"{path} is already blurred: heatlens rendered it through a lens, and another lens "
            "blurs it once more. Give the pinhole picture that it was made from"
        )
        if is_strict:
            raise InputError(f"{told}, or leave --strict out.")
        return (f"{told}.",)
    if JOB_ATTRIBUTE in header and BLURRED_ATTRIBUTE not in header:
        return (
            f"{path} was exported by an older heatlens, which did not tell whether through a lens: "
            "unless it is a pinhole plate, it is already blurred.",
        )
    return ()
