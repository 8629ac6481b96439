"""Find the separate files that belong to a picture: its depth, and pictures behind it."""

import os
import re
from collections.abc import Sequence as Items
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.files.picture_formats import is_picture, movie_of_frame, parse_movie_name
from heatlens.media.sequence.names import parse_frame_name, parse_pattern
from heatlens.media.sequence.sequence import Sequence
from heatlens.media.sequence.sequence_search import find_sequence

_DEPTH_WORDS = frozenset(
    ("depth", "depthmap", "z", "zdepth", "zbuffer", "disparity", "disp", "dpt", "distance", "midas")
)


def depth_path_for(path: Path, source: str) -> Path:
    """Return the file with the depth of the picture at `path`, as `companion_path` finds it."""
    return companion_path(path, source, "--depth", "depth")


def behind_paths(path: Path, options: PlateOptions) -> tuple[Path, ...]:
    """Return the files behind the plate at `path`; a pattern gives its frame of the same number."""
    return tuple(
        companion_path(path, text, "--behind", "picture behind") for text in options.behind
    )


def companion_path(path: Path, source: str, option: str, content: str) -> Path:
    """Return the file that belongs to the picture at `path`.

    This is `source`, or its frame of the same number if it is a pattern; frames of a movie are
    matched with others by their order. Raises InputError if there is no such frame or the picture
    has no number. The error names `option` and the `content` of the file.
    """
    companion = Path(os.path.expanduser(source))
    if _is_matched_by_order(path, companion):
        return _companion_by_order(path, find_sequence(source), content)
    if os.path.exists(companion) or parse_pattern(companion.name) is None:
        return companion
    frame = parse_frame_name(path.name)[1]
    if frame is None:
        raise InputError(
            f"{path} has no frame number in its name, so none of {source} belongs to it: name one "
            f"file with {option}."
        )
    sequence = find_sequence(source)
    frame_path = sequence.path_at(frame)
    if not sequence.has_file(frame):
        raise InputError(f"{frame_path} is missing: the {content} of {path}.")
    return frame_path


def _is_matched_by_order(path: Path, source: Path) -> bool:
    """Return whether frames of `source` are matched with pictures by order, not by number."""
    if parse_movie_name(source) is not None:
        return True
    return movie_of_frame(path) is not None and parse_pattern(source.name) is not None


def _companion_by_order(path: Path, source: Sequence, content: str) -> Path:
    """Return the frame of `source` with the same index as `path` has in its own sequence.

    Raises InputError if `source` has too few frames.
    """
    picture_sequence = find_sequence(path)
    movie, frame = movie_of_frame(path), picture_sequence.frame_at(path)
    index = (
        movie[1]
        if movie is not None
        else picture_sequence.frames.index(frame)
        if frame is not None
        else 0
    )
    if index >= len(source.frames):
        raise InputError(
            f"{source.pattern} has {len(source.frames)} frames, but {path} is the plate's frame "
            f"number {index + 1}: its {content} is missing."
        )
    return source.path_at(source.frames[index])


class PlateFiles:
    """Lists the files that a plate is read from: the picture, its depth and pictures behind it.

    The folder of a pattern is scanned only once. May be called from several threads.
    """

    def __init__(self, sources: Items[str]) -> None:
        """Keep the sources: files or patterns of the depth and of pictures behind, if any."""
        self._sources = tuple(sources)
        self._sequences: dict[str, Sequence] = {}

    def __call__(self, path: Path) -> tuple[Path, ...]:
        """Return the picture at `path`, then the files beside it, whether they exist or not.

        A pattern adds nothing if it has no file yet or the picture has no number.
        """
        return (
            path,
            *(file for source in self._sources for file in self._companions(path, source)),
        )

    def _companions(self, path: Path, source: str) -> tuple[Path, ...]:
        """Return the file of `source` for the picture at `path`; () if there is none."""
        companion, frame = Path(os.path.expanduser(source)), parse_frame_name(path.name)[1]
        is_in_order = _is_matched_by_order(path, companion)
        if not is_in_order and (os.path.exists(companion) or parse_pattern(companion.name) is None):
            return (companion,)
        try:
            sequence = self._sequences.get(source) or find_sequence(source)
            self._sequences[source] = sequence
            if is_in_order:
                return (_companion_by_order(path, sequence, "depth"),)
        except InputError:  # the pattern has no such file yet
            return ()
        return () if frame is None else (sequence.path_at(frame),)


def pair_picture_with_depth(names: Items[str]) -> tuple[str, str] | None:
    """Return (picture, depth) if the names of two files match as such a pair; else None.

    A depth with a number in its name stands for its whole sequence if the picture has a number too.
    """
    if len(names) != 2 or not all(_is_plate_file(name) for name in names):
        return None
    depths = [name for name in names if _has_depth_name(name)]
    if len(depths) != 1:
        return None
    (depth,) = depths
    (picture,) = (name for name in names if name != depth)
    return picture, _pattern_of_depth(picture, depth)


def _is_plate_file(name: str) -> bool:
    return Path(name).suffix.lower() == ".exr" or is_picture(Path(name))


def _has_depth_name(name: str) -> bool:
    """Return True if one of the words of a file's name says depth."""
    words = re.split(r"[^a-z]+", Path(name).stem.lower())
    return bool(_DEPTH_WORDS.intersection(words))


def _pattern_of_depth(picture: str, depth: str) -> str:
    """Return the pattern of the depth's sequence if both files are frames, else the file."""
    if (
        parse_frame_name(Path(picture).name)[1] is None
        or parse_frame_name(Path(depth).name)[1] is None
    ):
        return depth
    sequence = find_sequence(depth)
    return depth if len(sequence.present) == 1 else sequence.pattern
