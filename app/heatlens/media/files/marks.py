"""Marks that heatlens writes into its files: the job of an export, and whether a lens was applied.

An EXR holds each mark as an entry of its header, and a PNG as a text; other pictures and movies
have one comment for both. Without these marks a picture could be blurred twice.
"""

from collections.abc import Mapping

# The name of the mark that identifies the job of an exported frame. It must not be copied.
JOB_ATTRIBUTE = "heatlens:job"
# Whether a lens has been applied: YES, or _NO for a pinhole plate.
BLURRED_ATTRIBUTE = "heatlens:blurred"
IMAGE_DESCRIPTION = 270  # the TIFF and EXIF tag for a text

YES, _NO = "yes", "no"
_MARKS = (JOB_ATTRIBUTE, BLURRED_ATTRIBUTE)


def blurred_mark(is_blurred: bool) -> dict[str, str]:
    """Return the mark that says whether a picture went through a lens."""
    return {BLURRED_ATTRIBUTE: YES if is_blurred else _NO}


def marks_comment(marks: Mapping[str, str]) -> str:
    """Return the marks as one text, for files whose only text is a comment."""
    return " ".join(f"{name}={value}" for name, value in marks.items())


def parse_marks(comment: object) -> dict[str, str]:
    """Return the marks in a comment; none for the comment of another program."""
    text = comment.decode("ascii", "replace") if isinstance(comment, bytes) else str(comment or "")
    words = (word.partition("=") for word in text.split())
    return {name: value for name, _, value in words if name in _MARKS}


def picture_marks(info: Mapping[str, object], tags: Mapping[int, object]) -> dict[str, str]:
    """Return the marks in the texts of a picture and its TIFF or EXIF tags, as Pillow has them."""
    comment = info.get("comment") or tags.get(IMAGE_DESCRIPTION)
    return parse_marks(comment) | {name: str(info[name]) for name in _MARKS if name in info}
