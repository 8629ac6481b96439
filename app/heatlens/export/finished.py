"""Tell by the fingerprint in a file whether a frame is finished, and whether it may be replaced."""

import os
import warnings
from pathlib import Path

from PIL import Image

from heatlens.base.errors import InputError
from heatlens.export.frame_files import IMAGE_DESCRIPTION
from heatlens.export.output import MOVIE_SUFFIXES
from heatlens.export.plan import ExportPlan, PlannedFrame
from heatlens.export.whole import is_whole
from heatlens.files.movie_read import av
from heatlens.plate.exr.exr_scan import CutError, scanned_headers
from heatlens.plate.exr.exr_write import JOB_ATTRIBUTE

_UNREADABLE = (OSError, CutError, IndexError, ValueError, SyntaxError)  # the errors of the readers
_BEFORE_MARK = f"{JOB_ATTRIBUTE}="  # in formats whose only text entry is a comment


def is_finished(frame: PlannedFrame) -> bool:
    """Return True if the frame's file exists, has the same fingerprint and is complete."""
    path = frame.path
    return path.is_file() and is_whole(path) and fingerprint_in(path) == frame.fingerprint


def is_movie_finished(path: Path, fingerprint: str) -> bool:
    """Return True if the movie exists, has the same fingerprint and is complete.

    Raises InputError without PyAV.
    """
    return path.is_file() and fingerprint_in(path) == fingerprint and is_whole(path)


def fingerprint_in(path: Path) -> str | None:
    """Return the fingerprint that an export wrote into the file; None if no export wrote it.

    The pixels of the file may be cut off. Raises InputError for a movie without PyAV.
    """
    try:
        return _fingerprint(path)
    except _UNREADABLE:
        return None


def is_of_others(path: Path) -> bool:
    """Return True if the file can be read and no export wrote it.

    A file whose header cannot be read has nothing to lose. Raises InputError for a movie
    without PyAV.
    """
    try:
        return _fingerprint(path) is None
    except _UNREADABLE:
        return False


def _fingerprint(path: Path) -> str | None:
    """Return the fingerprint; raise one of _UNREADABLE if the header cannot be read."""
    suffix = path.suffix.lower()
    if suffix == ".exr":
        return _exr_fingerprint(path)
    return _marked(_movie_comment(path)) if suffix in MOVIE_SUFFIXES else _picture_mark(path)


def _exr_fingerprint(path: Path) -> str | None:
    with path.open("rb") as file:
        mark = scanned_headers(file)[0].get(JOB_ATTRIBUTE)
    return None if mark is None else mark.decode("ascii", "replace")


def _picture_mark(path: Path) -> str | None:
    """Read the text of a PNG, the comment of a JPEG, or the description of a TIFF."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Pillow warns of files that were cut off
        with Image.open(path) as image:
            info, tags = image.info, image.getexif()
    if JOB_ATTRIBUTE in info:
        return str(info[JOB_ATTRIBUTE])
    comment = info.get("comment") or tags.get(IMAGE_DESCRIPTION) or ""
    return _marked(comment.decode("ascii", "replace") if isinstance(comment, bytes) else comment)


def _movie_comment(path: Path) -> object:
    library = av()
    try:
        with library.open(str(path)) as container:
            return container.metadata.get("comment")
    except library.error.FFmpegError as error:
        raise ValueError(f"{path} is not a complete movie") from error


def _marked(comment: object) -> str | None:
    """Return the fingerprint in a comment; None for the comment of another program."""
    text = str(comment or "")
    return text.removeprefix(_BEFORE_MARK) if text.startswith(_BEFORE_MARK) else None


def check_replaced(plan: ExportPlan) -> None:
    """Raise InputError if files of others are in the place of frames and must not be replaced.

    Files of any earlier export are replaced without asking. So are empty files and files whose
    header cannot be read, because nothing can be lost.
    """
    if plan.job.options.overwrite:
        return
    paths = dict.fromkeys(frame.path for frame in plan.frames)
    others = [path for path in paths if _is_of_others(path)]
    if others:
        raise InputError(
            f"{_words(others, len(paths))} Choose another name or folder, or give --overwrite to "
            "replace what is there."
        )


def _is_of_others(path: Path) -> bool:
    return path.is_file() and os.path.getsize(path) > 0 and is_of_others(path)


def _words(others: list[Path], count: int) -> str:
    if count == 1:
        return f"{others[0]} already exists, and no export of heatlens wrote it."
    if len(others) == 1:
        return f"1 of the {count} files already exists, and no export wrote it: {others[0]}."
    return (
        f"{len(others)} of the {count} files already exist, and no export of heatlens wrote them; "
        f"{others[0]} is the first."
    )
