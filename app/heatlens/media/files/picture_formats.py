"""The formats of pictures besides EXR, each declared in one record, and the frames of movies.

Whatever differs between the formats is a field of `PictureFormat`, so a new format is one more
record in `FORMATS`, from which readers, writers, menus and help derive.

A movie stands for a folder of its frames: clip.mov/frame.0012.mov is the twelfth frame of clip.mov.
The frames of clip.mov@1001 are counted from 1001.
"""

import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import OnUse
from heatlens.media.files.whole_pictures import (
    is_complete_jpeg,
    is_complete_png,
    is_complete_tiff,
    is_complete_webp,
)

if TYPE_CHECKING:
    from heatlens.media.files.picture_encoding import Stored

MOVIES_READ = (".mov", ".mp4", ".m4v", ".mxf", ".webm", ".mkv")
_FIRST_FRAME = 1
_MOVIE = re.compile(
    rf"(.+(?:{'|'.join(map(re.escape, MOVIES_READ))}))(?:@([0-9]{{1,9}}))?",
    re.IGNORECASE | re.DOTALL,
)
_FRAME = re.compile(r"frame\.([0-9]{4,10})\..*", re.ASCII)


@dataclass(frozen=True)
class Writing:
    """How pictures of one format are written, and recognized by the next export.

    encoded      returns the bytes of a file for whole numbers (H, W, 3 or 4) and marks
    marks        returns the marks in a file; raises ValueError or what its library does
    is_whole     returns for an open file and its length whether the file is complete
    bits         of each channel
    keeps_alpha  it holds transparency; without it, pictures lie over black
    most_px      the longest side
    require      raises InputError if a package is missing
    """

    encoded: Callable[["Stored", Mapping[str, str]], bytes]
    marks: Callable[[Path], dict[str, str]]
    is_complete: Callable[[BinaryIO, int], bool]
    bits: int = 8
    keeps_alpha: bool = True
    most_px: int = 65535
    require: Callable[[], object] = tuple


@dataclass(frozen=True)
class PictureFormat:
    """One format of pictures: everything that differs between formats.

    word       what menus and sentences call it
    suffixes   its file extensions in lower case, the usual one first
    begins     the first bytes that its files may have; () if they do not identify it
    of_pillow  Pillow's names of the formats that may be in it; () if it is read without Pillow
    writing    how it is written; None if it is only read
    """

    word: str
    suffixes: tuple[str, ...]
    begins: tuple[bytes, ...] = ()
    of_pillow: tuple[str, ...] = ()
    writing: Writing | None = None


# Each command line reads this table; NumPy and Pillow, which encode, are slow to import.
_encoding = partial(OnUse, "media.files.picture_encoding")
_dpx = partial(OnUse, "media.files.dpx")
_by_pillow = partial(Writing, marks=OnUse("media.files.opened_by_ending", "marks_by_pillow"))
# Pillow has no other name for a JPEG with further pictures behind the first, as of phones.
FORMATS = [
    PictureFormat(
        word="PNG",
        suffixes=(".png",),
        begins=(b"\x89PNG",),
        of_pillow=("PNG",),
        writing=_by_pillow(encoded=_encoding("png_bytes"), is_complete=is_complete_png),
    ),
    PictureFormat(
        word="JPEG",
        suffixes=(".jpg", ".jpeg"),
        begins=(b"\xff\xd8\xff",),
        of_pillow=("JPEG",),
        writing=_by_pillow(
            encoded=_encoding("jpeg_bytes"),
            is_complete=is_complete_jpeg,
            keeps_alpha=False,
        ),
    ),
    PictureFormat(
        word="TIFF",
        suffixes=(".tif", ".tiff"),
        begins=(b"II*\0", b"MM\0*"),
        of_pillow=("TIFF",),
        writing=_by_pillow(encoded=_encoding("tiff_bytes"), is_complete=is_complete_tiff),
    ),
    PictureFormat("HEIC", (".heic", ".heif"), of_pillow=("HEIF",)),
    PictureFormat(
        word="WebP",
        suffixes=(".webp",),
        begins=(b"RIFF",),
        of_pillow=("WEBP",),
        writing=_by_pillow(
            encoded=_encoding("webp_bytes"),
            is_complete=is_complete_webp,
            most_px=16383,
        ),
    ),
    PictureFormat(
        word="DPX",
        suffixes=(".dpx",),
        begins=(b"SDPX", b"XPDS"),
        writing=Writing(
            encoded=_dpx("dpx_bytes"),
            marks=_dpx("dpx_marks"),
            is_complete=_dpx("is_complete_dpx"),
            bits=10,
            keeps_alpha=False,
            require=_dpx("require_openimageio"),
        ),
    ),
    PictureFormat(word="BMP", suffixes=(".bmp",), begins=(b"BM",), of_pillow=("BMP", "DIB")),
    PictureFormat("TGA", (".tga",), of_pillow=("TGA",)),
    PictureFormat("AVIF", (".avif",), of_pillow=("AVIF",)),
    PictureFormat("PFM", (".pfm",)),
    PictureFormat(word="NumPy", suffixes=(".npy",), begins=(b"\x93NUMPY",)),
]


def format_of(path: str | os.PathLike[str]) -> PictureFormat | None:
    """Return the format for the ending of a name; None for EXR, movies and others."""
    suffix = Path(path).suffix.lower()
    return next(
        (picture_format for picture_format in FORMATS if suffix in picture_format.suffixes), None
    )


def writing_of(path: str | os.PathLike[str]) -> Writing:
    """Return how the format of a name is written. Raises InputError for names of no such format."""
    picture_format = format_of(path)
    if picture_format is None or picture_format.writing is None:
        raise InputError(f"{path}: pictures are written as {', '.join(suffixes_written()[1:])}.")
    return picture_format.writing


def suffixes_read() -> tuple[str, ...]:
    """Return the endings of all pictures that can be read."""
    return (".exr", *(suffix for picture_format in FORMATS for suffix in picture_format.suffixes))


def suffixes_written() -> tuple[str, ...]:
    """Return the endings of all pictures that can be written, EXR as the first."""
    return (
        ".exr",
        *(
            suffix
            for picture_format in FORMATS
            if picture_format.writing
            for suffix in picture_format.suffixes
        ),
    )


def words_written() -> str:
    """Return the endings of the pictures that can be written, each with its bits, for the help."""
    return ", ".join(
        f"{picture_format.suffixes[0]} ({picture_format.writing.bits} bits)"
        for picture_format in FORMATS
        if picture_format.writing
    )


def is_picture(path: Path) -> bool:
    """Return whether the name is that of a readable picture other than EXR, or of a movie."""
    return format_of(path) is not None or parse_movie_name(path) is not None


def parse_movie_name(path: Path) -> tuple[Path, int] | None:
    """Return the file of a movie and the number of its first frame; None for another name."""
    match = _MOVIE.fullmatch(path.name)
    if match is None:
        return None
    return path.with_name(match[1]), _FIRST_FRAME if match[2] is None else int(match[2])


def movie_frame_name(movie: Path, frame: int) -> str:
    """Return the name of a frame in the folder that `movie` stands for."""
    return f"frame.{frame:04d}{movie.suffix}"


def movie_of_frame(path: Path) -> tuple[Path, int] | None:
    """Return the movie file of which `path` is a frame, and the number of frames before it.

    The movie itself stands for its first frame. None if `path` is not a movie.
    """
    parent_movie, match = parse_movie_name(path.parent), _FRAME.fullmatch(path.name)
    if parent_movie is not None and match is not None:
        return parent_movie[0], int(match[1]) - parent_movie[1]
    movie = parse_movie_name(path)
    return None if movie is None else (movie[0], 0)


def file_on_disk(path: Path) -> Path:
    """Return the file that holds the picture at `path`: a movie for each of its frames."""
    movie = movie_of_frame(path)
    return path if movie is None else movie[0]
