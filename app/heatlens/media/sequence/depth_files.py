"""Find the separate files that belong to a picture: its depth, and pictures behind it."""

import os
import re
from collections.abc import Sequence as Items
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.media.files.picture_formats import in_movie, is_picture, movie_named
from heatlens.media.sequence.names import form_of, parse_pattern
from heatlens.media.sequence.sequence import Sequence, find_sequence

_DEPTH_WORDS = frozenset(
    ("depth", "depthmap", "z", "zdepth", "zbuffer", "disparity", "disp", "dpt", "distance", "midas")
)


def depth_path_for(path: Path, source: str) -> Path:
    """Return the file that holds the depth of the picture at `path`, as `beside_path` finds it."""
    return beside_path(path, source, "--depth", "depth")


def beside_path(path: Path, source: str, option: str, what: str) -> Path:
    """Return the file that belongs to the picture at `path`.

    This is `source`, or its frame of the same number if it is a pattern; frames of a movie go with
    others in order. Raises InputError if there is no such frame or the picture has no number. The
    error names `option` and `what` the file holds.
    """
    other = Path(os.path.expanduser(source))
    if _go_in_order(path, other):
        return _in_order(path, find_sequence(source), what)
    if os.path.exists(other) or parse_pattern(other.name) is None:
        return other
    frame = form_of(path.name)[1]
    if frame is None:
        raise InputError(
            f"{path} has no frame number in its name, so none of {source} belongs to it: name one "
            f"file with {option}."
        )
    sequence = find_sequence(source)
    beside = sequence.path_at(frame)
    if not sequence.has(frame):
        raise InputError(f"{beside} is missing: the {what} of {path}.")
    return beside


def _go_in_order(path: Path, source: Path) -> bool:
    """Return whether the frames of `source` belong to those beside `path` first with first."""
    if movie_named(source) is not None:
        return True
    return in_movie(path) is not None and parse_pattern(source.name) is not None


def _in_order(path: Path, source: Sequence, what: str) -> Path:
    """Return the frame of `source` with as many before it as `path` has in its own sequence."""
    own = find_sequence(path)
    movie, frame = in_movie(path), own.frame_at(path)
    at = movie[1] if movie is not None else own.frames.index(frame) if frame is not None else 0
    if at >= len(source.frames):
        raise InputError(
            f"{source.pattern} has {len(source.frames)} frames, but {path} is number {at + 1} of "
            f"its own: its {what} is missing."
        )
    return source.path_at(source.frames[at])


class PlateFiles:
    """Lists the files that a plate is read from: the picture, its depth and pictures behind it.

    The folder of a pattern is scanned only once. May be called from several threads.
    """

    def __init__(self, sources: Items[str]) -> None:
        """Keep the files or patterns of the depth and of pictures behind, if any."""
        self._sources = tuple(sources)
        self._frames: dict[str, Sequence] = {}

    def __call__(self, path: Path) -> tuple[Path, ...]:
        """Return the picture at `path`, then the files beside it, whether they exist or not.

        A pattern adds nothing if it has no file yet or the picture has no number.
        """
        return (path, *(file for it in self._sources for file in self._beside(path, it)))

    def _beside(self, path: Path, source: str) -> tuple[Path, ...]:
        other, frame = Path(os.path.expanduser(source)), form_of(path.name)[1]
        is_in_order = _go_in_order(path, other)
        if not is_in_order and (os.path.exists(other) or parse_pattern(other.name) is None):
            return (other,)
        try:
            frames = self._frames.get(source) or find_sequence(source)
            self._frames[source] = frames
            if is_in_order:
                return (_in_order(path, frames, "depth"),)
        except InputError:  # the pattern has no such file yet
            return ()
        return () if frame is None else (frames.path_at(frame),)


def picture_and_depth(names: Items[str]) -> tuple[str, str] | None:
    """Return (picture, depth) if the names of two files say that they belong together; else None.

    A depth with a number in its name stands for its whole sequence if the picture has a number too.
    """
    if len(names) != 2 or not all(_is_plate_file(name) for name in names):
        return None
    depths = [name for name in names if _is_called_depth(name)]
    if len(depths) != 1:
        return None
    (depth,) = depths
    (picture,) = (name for name in names if name != depth)
    return picture, _with_its_frames(picture, depth)


def _is_plate_file(name: str) -> bool:
    return Path(name).suffix.lower() == ".exr" or is_picture(Path(name))


def _is_called_depth(name: str) -> bool:
    words = re.split(r"[^a-z]+", Path(name).stem.lower())
    return bool(_DEPTH_WORDS.intersection(words))


def _with_its_frames(picture: str, depth: str) -> str:
    """Return the pattern of the depth's sequence if both files are frames, else the file."""
    if form_of(Path(picture).name)[1] is None or form_of(Path(depth).name)[1] is None:
        return depth
    sequence = find_sequence(depth)
    return depth if len(sequence.present) == 1 else sequence.pattern
