"""Tell whether a frame is finished, and whether its file may be replaced.

The fingerprint in a file tells what it shows. A file that was cut short by a full disk, a broken
copy or a power cut still has a valid header, so its structure is checked without reading its
pixels: each format contains the length that the file must have.

Source: ISO/IEC 14496-12, section 4.2.
"""

import os
import struct
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import opened_file
from heatlens.deliver.export.output import MOVIE_SUFFIXES
from heatlens.deliver.export.plan import ExportPlan, PlannedFrame
from heatlens.media.files.marks import JOB_ATTRIBUTE, marks_in
from heatlens.media.files.movie_read import av
from heatlens.media.files.opened_by_ending import movie_for_reading
from heatlens.media.files.picture_formats import writing_of
from heatlens.media.plate.exr.exr_scan import CutError, scanned_headers
from heatlens.media.plate.exr.exr_whole import end_of_chunks

_UNREADABLE = (OSError, CutError, IndexError, ValueError, SyntaxError)  # the errors of the readers


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
    marks = _movie_marks(path) if suffix in MOVIE_SUFFIXES else writing_of(path).marks(path)
    return marks.get(JOB_ATTRIBUTE)


def _exr_fingerprint(path: Path) -> str | None:
    with opened_file(path) as file:
        mark = scanned_headers(file)[0].get(JOB_ATTRIBUTE)
    return None if mark is None else mark.decode("ascii", "replace")


def _movie_marks(path: Path) -> dict[str, str]:
    library = av()
    try:
        with movie_for_reading(library, path) as container:
            return marks_in(container.metadata.get("comment"))
    except library.error.FFmpegError as error:
        raise ValueError(f"{path} is not a complete movie") from error


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


# The length must be equal, not only sufficient: a file that goes on after its last chunk was taken
# for finished at first.
def is_whole(path: Path, suffix: str = "") -> bool:
    """Return whether a file is as long as its own structure says.

    `suffix`, such as .exr, gives its kind if its name does not.
    """
    kind = (suffix or path.suffix).lower()
    check = _CHECKS.get(kind) or writing_of(f"a{kind}").is_whole
    try:
        with opened_file(path) as file:
            size = os.fstat(file.fileno()).st_size
            return size > 0 and check(file, size)
    except (OSError, struct.error, ValueError, LookupError):  # the structure itself is cut off
        return False


def _is_whole_movie(file: BinaryIO, size: int) -> bool:
    """Return True if the boxes of QuickTime or MP4 reach to the end, and one holds the pictures."""
    end, kinds = 0, set()
    while end < size:
        file.seek(end)
        length, kind = struct.unpack(">I4s", file.read(8))
        head = 8
        if length == 1:  # the length has 64 bits, after the kind
            (length,), head = struct.unpack(">Q", file.read(8)), 16
        if length < head:
            return False
        kinds.add(kind)
        end += length
    return end == size and {b"moov", b"mdat"} <= kinds


_CHECKS: dict[str, Callable[[BinaryIO, int], bool]] = {
    ".exr": lambda file, size: end_of_chunks(file) == size,
    **dict.fromkeys(MOVIE_SUFFIXES, _is_whole_movie),
}
