"""Depth in a file of its own: which file belongs to a picture, and its pixels on the picture's."""

import re
from collections.abc import Sequence as Items
from pathlib import Path

from heatlens.errors import InputError
from heatlens.files.picture_formats import is_picture
from heatlens.sequence.names import form_of, parse_pattern
from heatlens.sequence.sequence import Sequence, find_sequence

_DEPTH_WORDS = frozenset(
    ("depth", "depthmap", "z", "zdepth", "zbuffer", "disparity", "disp", "dpt", "distance", "midas")
)


def depth_path_for(path: Path, source: str) -> Path:
    """Return the depth of the picture at `path`: the file `source`, or the frame of that pattern.

    Raises InputError where a pattern has no such frame, or the picture no number.
    """
    found = Path(source).expanduser()
    if found.exists() or parse_pattern(found.name) is None:
        return found
    frame = form_of(path.name)[1]
    if frame is None:
        raise InputError(
            f"{path} has no frame number in its name, so none of {source} belongs to it: name one "
            "file with --depth."
        )
    sequence = find_sequence(source)
    depth = sequence.path_at(frame)
    if not sequence.has(frame):
        raise InputError(f"{depth} is missing: the depth of {path}.")
    return depth


class PlateFiles:
    """Names the files that a plate is read from: the picture, and its depth where that is apart.

    The folder of a pattern is looked into once; after that names are only put together. May be
    called from several threads.
    """

    def __init__(self, depth_source: str | None) -> None:
        """Take a file or a pattern for the depth; None where the picture holds the depth."""
        self._source = depth_source
        self._frames: Sequence | None = None

    def __call__(self, path: Path) -> tuple[Path, ...]:
        """Return the picture at `path` first, then the file of its depth, there or not.

        A picture that no depth belongs to stands alone.
        """
        return (path,) if self._source is None else (path, *self._depth_of(path, self._source))

    def _depth_of(self, path: Path, source: str) -> tuple[Path, ...]:
        found, frame = Path(source).expanduser(), form_of(path.name)[1]
        if found.exists() or parse_pattern(found.name) is None:
            return (found,)
        try:
            self._frames = self._frames or find_sequence(source)
        except InputError:  # no depth is there yet
            return ()
        return () if frame is None else (self._frames.path_at(frame),)


def picture_and_depth(names: Items[str]) -> tuple[str, str] | None:
    """Return a picture and its depth, where two files are that by their names; else None.

    A depth with a number in its name stands for the sequence that it is a frame of, if the picture
    has a number too.
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
    """Return the pattern of the depth's sequence where both are frames of one, else the file."""
    if form_of(Path(picture).name)[1] is None or form_of(Path(depth).name)[1] is None:
        return depth
    sequence = find_sequence(depth)
    return depth if len(sequence.present) == 1 else sequence.pattern
