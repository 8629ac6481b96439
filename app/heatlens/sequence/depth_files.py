"""Depth in a file of its own: which file belongs to a picture, and its pixels on the picture's."""

import re
from collections.abc import Sequence
from pathlib import Path

from heatlens.errors import InputError
from heatlens.files.picture_formats import is_picture
from heatlens.sequence.names import form_of, parse_pattern
from heatlens.sequence.sequence import find_sequence

_DEPTH_WORDS = frozenset(
    ("depth", "depthmap", "z", "zdepth", "zbuffer", "disparity", "disp", "dpt", "distance", "midas")
)


def depth_path_for(path: Path, source: str) -> Path:
    """The depth of the picture at `path`: the file `source`, or the frame of that pattern.

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


def picture_and_depth(names: Sequence[str]) -> tuple[str, str] | None:
    """A picture and its depth, where two files are just that by their names; else None.

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
    """The pattern of the depth's sequence where both are frames of one, else the file."""
    if form_of(Path(picture).name)[1] is None or form_of(Path(depth).name)[1] is None:
        return depth
    sequence = find_sequence(depth)
    return depth if len(sequence.present) == 1 else sequence.pattern
