"""Tell whether a frame is finished, and whether its file may be replaced.

The fingerprint in a file tells what it shows. A file that was cut short by a full disk, a broken
copy or a power cut still has a valid header, so its structure is checked without reading its
pixels: each of these formats contains the length that the file must have.

Sources: W3C, PNG specification, section 5; ISO/IEC 10918-1, annex B; Adobe, TIFF revision 6.0,
section 2; ISO/IEC 14496-12, section 4.2.
"""

import os
import struct
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

from heatlens.base.errors import InputError
from heatlens.base.paths import opened_file
from heatlens.export.output import MOVIE_SUFFIXES
from heatlens.export.plan import ExportPlan, PlannedFrame
from heatlens.files.marks import JOB_ATTRIBUTE, marks_in, picture_marks
from heatlens.files.movie_read import av
from heatlens.files.opened_by_ending import movie_for_reading, picture_at
from heatlens.plate.exr.exr_scan import CutError, end_of_chunks, scanned_headers

_UNREADABLE = (OSError, CutError, IndexError, ValueError, SyntaxError)  # the errors of the readers
_JPEG_END = b"\xff\xd9"
_BYTES_OF_TIFF = (0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8)  # bytes of a value, by type number
_STRIP_OFFSETS, _STRIP_LENGTHS = 273, 279


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
    marks = _movie_marks(path) if suffix in MOVIE_SUFFIXES else _picture_marks(path)
    return marks.get(JOB_ATTRIBUTE)


def _exr_fingerprint(path: Path) -> str | None:
    with opened_file(path) as file:
        mark = scanned_headers(file)[0].get(JOB_ATTRIBUTE)
    return None if mark is None else mark.decode("ascii", "replace")


def _picture_marks(path: Path) -> dict[str, str]:
    """Read the texts of a PNG, the comment of a JPEG, or the description of a TIFF."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Pillow warns of files that were cut off
        image = picture_at(path)
        if image is None:
            raise ValueError(f"{path} is not a picture of an export")
        with image:
            info = {str(name): value for name, value in image.info.items()}
            return picture_marks(info, image.getexif())


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


def is_whole(path: Path, suffix: str = "") -> bool:
    """Return whether a file is as long as its own structure says.

    `suffix`, such as .exr, gives its kind if its name does not.
    """
    check = _CHECKS[(suffix or path.suffix).lower()]
    try:
        with opened_file(path) as file:
            size = os.fstat(file.fileno()).st_size
            return size > 0 and check(file, size)
    except (OSError, struct.error, ValueError, LookupError):  # the structure itself is cut off
        return False


def _is_whole_png(file: BinaryIO, size: int) -> bool:
    """Return True if the chunks lead to IEND as the last one."""
    end, kind = 8, b""
    while end < size and kind != b"IEND":
        file.seek(end)
        length, kind = struct.unpack(">I4s", file.read(8))
        end += 12 + length
    return kind == b"IEND" and end == size


def _is_whole_jpeg(file: BinaryIO, size: int) -> bool:
    file.seek(size - len(_JPEG_END))
    return file.read() == _JPEG_END


def _is_whole_tiff(file: BinaryIO, size: int) -> bool:
    """Return True if the file contains all of its directory, its values and its pixel strips."""
    order = {b"II*\0": "<", b"MM\0*": ">"}[file.read(4)]
    (start,) = struct.unpack(f"{order}I", file.read(4))
    file.seek(start)
    (count,) = struct.unpack(f"{order}H", file.read(2))
    entries = [struct.unpack(f"{order}HHI4s", file.read(12)) for _ in range(count)]
    ends, found = [start + 2 + 12 * count + 4], {}
    for tag, kind, number, data in entries:
        length = _BYTES_OF_TIFF[kind] * number
        if length > 4:
            (at,) = struct.unpack(f"{order}I", data)
            ends.append(at + length)
            file.seek(at)
            data = file.read(length)
        if tag in (_STRIP_OFFSETS, _STRIP_LENGTHS):
            found[tag] = struct.unpack(f"{order}{number}{'H' if kind == 3 else 'I'}", data[:length])
    strips = zip(found[_STRIP_OFFSETS], found[_STRIP_LENGTHS], strict=True)
    ends += [offset + length for offset, length in strips]
    return bool(max(ends) == size)


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
    ".png": _is_whole_png,
    ".jpg": _is_whole_jpeg,
    ".jpeg": _is_whole_jpeg,
    ".tif": _is_whole_tiff,
    ".tiff": _is_whole_tiff,
    ".mov": _is_whole_movie,
    ".mp4": _is_whole_movie,
}
