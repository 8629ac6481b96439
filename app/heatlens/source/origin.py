"""Record the files that a frame is made of, and their state when it was planned."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from heatlens.sequence.sequence import Stamp, stamp_of


@dataclass(frozen=True)
class StampedFile:
    """A file and its stamp from before it was read; None for a missing file."""

    path: Path
    stamp: Stamp | None


def stamped(paths: Iterable[Path]) -> tuple[StampedFile, ...]:
    """Return the files with their current stamps."""
    return tuple(StampedFile(path, stamp_of(path)) for path in paths)


@dataclass(frozen=True)
class Origin:
    """The files that one frame of a shot is made of.

    frame     number of the plate that is read for it; for a scene, the frame itself
    is_black  True if only the size of that plate is used, and its pixels become black
    files     the file that is read, then the files that it names or that belong to it;
              empty for the built-in scene
    """

    frame: int
    is_black: bool = False
    files: tuple[StampedFile, ...] = ()
