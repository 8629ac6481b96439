"""The file extensions of the pictures that can be read besides EXR, and the frames of movies.

A movie stands for a folder of its frames: clip.mov/frame.0012.mov is the twelfth frame of clip.mov.
The frames of clip.mov@1001 are counted from 1001.
"""

import re
from pathlib import Path

PICTURES_READ = (
    *(".png", ".jpg", ".jpeg", ".tif", ".tiff", ".heic", ".heif", ".webp", ".bmp", ".tga"),
    *(".avif", ".pfm", ".npy"),
)
MOVIES_READ = (".mov", ".mp4", ".m4v", ".mxf", ".webm", ".mkv")
_FIRST_FRAME = 1
_MOVIE = re.compile(
    rf"(.+(?:{'|'.join(map(re.escape, MOVIES_READ))}))(?:@([0-9]{{1,9}}))?",
    re.IGNORECASE | re.DOTALL,
)
_FRAME = re.compile(r"frame\.([0-9]{4,10})\..*", re.ASCII)


def is_picture(path: Path) -> bool:
    """Return whether the name is that of a readable picture other than EXR, or of a movie."""
    return path.suffix.lower() in PICTURES_READ or movie_named(path) is not None


def movie_named(path: Path) -> tuple[Path, int] | None:
    """Return the file of a movie and the number of its first frame; None for another name."""
    found = _MOVIE.fullmatch(path.name)
    if found is None:
        return None
    return path.with_name(found[1]), _FIRST_FRAME if found[2] is None else int(found[2])


def movie_frame_name(movie: Path, frame: int) -> str:
    """Return the name of a frame in the folder that `movie` stands for."""
    return f"frame.{frame:04d}{movie.suffix}"


def in_movie(path: Path) -> tuple[Path, int] | None:
    """Return the file of the movie of which `path` is a frame, and how many frames come before it.

    The movie itself stands for its first frame. None if `path` is not a movie.
    """
    folder, found = movie_named(path.parent), _FRAME.fullmatch(path.name)
    if folder is not None and found is not None:
        return folder[0], int(found[1]) - folder[1]
    alone = movie_named(path)
    return None if alone is None else (alone[0], 0)


def file_on_disk(path: Path) -> Path:
    """Return the file that holds the picture at `path`: a movie for each of its frames."""
    found = in_movie(path)
    return path if found is None else found[0]
