"""Check whether a frame is finished, and whether its file may be replaced.

The fingerprint in a file identifies its picture. A file that was cut short by a full disk, a broken
copy or a power cut still has a valid header. Therefore its structure is checked, without reading
its pixels: each format contains the length that the file must have.

Source: ISO/IEC 14496-12, section 4.2.
"""

import os
import struct
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import open_regular_file
from heatlens.deliver.export.output import MOVIE_SUFFIXES
from heatlens.deliver.export.plan import ExportPlan, PlannedFrame
from heatlens.media.files.marks import JOB_ATTRIBUTE, parse_marks
from heatlens.media.files.movie_read import av
from heatlens.media.files.opened_by_ending import open_movie
from heatlens.media.files.picture_formats import writing_of
from heatlens.media.plate.exr.exr_scan import CutError, scan_headers
from heatlens.media.plate.exr.exr_whole import end_of_chunks

_UNREADABLE = (OSError, CutError, IndexError, ValueError, SyntaxError)  # the errors of the readers


def is_finished(frame: PlannedFrame) -> bool:
    """Return True if the frame's file exists, has the same fingerprint and is complete."""
    path = frame.path
    return path.is_file() and is_complete(path) and fingerprint_in(path) == frame.fingerprint


def is_movie_finished(path: Path, fingerprint: str) -> bool:
    """Return True if the movie exists, has the same fingerprint and is complete.

    Raises InputError without PyAV.
    """
    return path.is_file() and fingerprint_in(path) == fingerprint and is_complete(path)


def fingerprint_in(path: Path) -> str | None:
    """Return the fingerprint that an export wrote into the file; None if no export wrote it.

    The pixels of the file may be cut off. Raises InputError for a movie without PyAV.
    """
    try:
        return _fingerprint(path)
    except _UNREADABLE:
        return None


def is_foreign_file(path: Path) -> bool:
    """Return True if the header of the file can be read and no export of heatlens wrote it.

    Returns False for a file whose header cannot be read, because its content is lost already.
    Raises InputError for a movie without PyAV.
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
    """Return the fingerprint of the job that wrote an EXR; None if it holds none."""
    with open_regular_file(path) as file:
        mark = scan_headers(file)[0].get(JOB_ATTRIBUTE)
    return None if mark is None else mark.decode("ascii", "replace")


def _movie_marks(path: Path) -> dict[str, str]:
    """Return the marks that an export left in a movie. Raises ValueError for a damaged one."""
    library = av()
    try:
        with open_movie(library, path) as container:
            return parse_marks(container.metadata.get("comment"))
    except library.error.FFmpegError as error:
        raise ValueError(f"{path} is not a complete movie") from error


def check_may_replace(plan: ExportPlan) -> None:
    """Raise InputError if the export would replace files that no export of heatlens wrote.

    Files of any earlier export are replaced without asking. So are empty files and files whose
    header cannot be read, because nothing can be lost.
    """
    if plan.job.options.overwrite:
        return
    paths = dict.fromkeys(frame.path for frame in plan.frames)
    foreign_paths = [path for path in paths if _must_not_be_replaced(path)]
    if foreign_paths:
        raise InputError(
            f"{_foreign_files_message(foreign_paths, len(paths))} Choose another name or folder, "
            "or give --overwrite to "
            "replace what is there."
        )


def _must_not_be_replaced(path: Path) -> bool:
    """Return True for a readable file that is not empty and that no export of heatlens wrote."""
    return path.is_file() and os.path.getsize(path) > 0 and is_foreign_file(path)


def _foreign_files_message(foreign_paths: list[Path], count: int) -> str:
    """Return the refusal to replace files of other programs, of `count` outputs in all."""
    if count == 1:
        return f"{foreign_paths[0]} already exists, and no export of heatlens wrote it."
    if len(foreign_paths) == 1:
        return f"1 of the {count} files already exists, and no export wrote it: {foreign_paths[0]}."
    return (
        f"{len(foreign_paths)} of the {count} files already exist, and no export of heatlens "
        "wrote them; "
        f"{foreign_paths[0]} is the first."
    )


# The length must be equal, not only sufficient: a file with bytes after its last chunk is not
# finished.
def is_complete(path: Path, suffix: str = "") -> bool:
    """Return whether a file is as long as its own structure says.

    `suffix`, such as .exr, gives its kind if its name does not.
    """
    kind = (suffix or path.suffix).lower()
    check = _CHECKS.get(kind) or writing_of(f"a{kind}").is_complete
    try:
        with open_regular_file(path) as file:
            size = os.fstat(file.fileno()).st_size
            return size > 0 and check(file, size)
    except (OSError, struct.error, ValueError, LookupError):  # the structure itself is cut off
        return False


def _is_complete_movie(file: BinaryIO, size: int) -> bool:
    """Return True if the boxes of QuickTime or MP4 reach to the end, and one holds the pictures."""
    end, kinds = 0, set()
    while end < size:
        file.seek(end)
        length, kind = struct.unpack(">I4s", file.read(8))
        header_bytes = 8
        if length == 1:  # the length has 64 bits, after the kind
            (length,), header_bytes = struct.unpack(">Q", file.read(8)), 16
        if length < header_bytes:
            return False
        kinds.add(kind)
        end += length
    return end == size and {b"moov", b"mdat"} <= kinds


_CHECKS: dict[str, Callable[[BinaryIO, int], bool]] = {
    ".exr": lambda file, size: end_of_chunks(file) == size,
    **dict.fromkeys(MOVIE_SUFFIXES, _is_complete_movie),
}
