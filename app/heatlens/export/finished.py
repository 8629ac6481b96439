"""Find the fingerprint in an exported file without reading its pixels."""

from pathlib import Path

import OpenEXR
from PIL import Image

from heatlens.export.frame_files import IMAGE_DESCRIPTION
from heatlens.export.movie_library import av
from heatlens.export.plan import PlannedFrame
from heatlens.export.whole import is_whole
from heatlens.files.quiet import quiet_library
from heatlens.plate.exr_write import JOB_ATTRIBUTE


def is_finished(frame: PlannedFrame) -> bool:
    """Return True if the frame's file exists, has the same fingerprint and is complete."""
    if not frame.path.is_file():
        return False
    read = _exr_fingerprint if frame.path.suffix.lower() == ".exr" else _picture_fingerprint
    return is_whole(frame.path) and read(frame.path) == frame.fingerprint


def is_movie_finished(path: Path, fingerprint: str) -> bool:
    """Return True if the movie exists, has the same fingerprint and is complete.

    Raises InputError without PyAV.
    """
    if not path.is_file():
        return False
    library = av()
    try:
        with library.open(str(path)) as container:
            comment = container.metadata.get("comment")
    except library.error.FFmpegError:
        return False
    return comment == f"{JOB_ATTRIBUTE}={fingerprint}" and is_whole(path)


def _exr_fingerprint(path: Path) -> object:
    try:
        with quiet_library():
            parts = OpenEXR.File(str(path), header_only=True).parts
    except (RuntimeError, ValueError):  # a UnicodeDecodeError is a ValueError
        return None
    return parts[0].header.get(JOB_ATTRIBUTE) if parts else None


def _picture_fingerprint(path: Path) -> object:
    """Return the text of a PNG, the comment of a JPEG, the description of a TIFF."""
    try:
        with Image.open(path) as image:
            info, tags = image.info, image.getexif()
    except (OSError, ValueError, SyntaxError):
        return None
    comment = info.get("comment") or tags.get(IMAGE_DESCRIPTION) or ""
    said = comment.decode("ascii", "replace") if isinstance(comment, bytes) else str(comment)
    return info.get(JOB_ATTRIBUTE) or said.removeprefix(f"{JOB_ATTRIBUTE}=")
