"""What heatlens writes into its own files: what an export made, and whether it went through a lens.

An EXR holds each mark as an entry of its header, and a PNG as a text; other pictures and movies
have one comment for both. Without these marks a picture could be blurred twice.
"""

from collections.abc import Mapping

# What an exported frame was made of. It must not be copied to other files.
JOB_ATTRIBUTE = "heatlens:job"
# Whether a lens has been applied: YES, or _NO for a pinhole plate.
BLURRED_ATTRIBUTE = "heatlens:blurred"
IMAGE_DESCRIPTION = 270  # the TIFF and EXIF tag for a text

YES, _NO = "yes", "no"
_MARKS = (JOB_ATTRIBUTE, BLURRED_ATTRIBUTE)


def blurred_mark(is_blurred: bool) -> dict[str, str]:
    """Return the mark of a picture that went through a lens, or of one that did not."""
    return {BLURRED_ATTRIBUTE: YES if is_blurred else _NO}


def comment_of(marks: Mapping[str, str]) -> str:
    """Return the marks as one text, for files whose only text is a comment."""
    return " ".join(f"{name}={value}" for name, value in marks.items())


def marks_in(comment: object) -> dict[str, str]:
    """Return the marks in a comment; none for the comment of another program."""
    text = comment.decode("ascii", "replace") if isinstance(comment, bytes) else str(comment or "")
    words = (word.partition("=") for word in text.split())
    return {name: value for name, _, value in words if name in _MARKS}


def picture_marks(info: Mapping[str, object], tags: Mapping[int, object]) -> dict[str, str]:
    """Return the marks in the texts of a picture and its TIFF or EXIF tags, as Pillow has them."""
    comment = info.get("comment") or tags.get(IMAGE_DESCRIPTION)
    return marks_in(comment) | {name: str(info[name]) for name in _MARKS if name in info}
