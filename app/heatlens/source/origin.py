"""The files that one frame is made of, and the state in which they were when it was planned."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from heatlens.sequence.sequence import Stamp, stamp_of


@dataclass(frozen=True)
class StampedFile:
    """A file and its stamp before it was read; the stamp of a missing file is None."""

    path: Path
    stamp: Stamp | None


def stamped(paths: Iterable[Path]) -> tuple[StampedFile, ...]:
    """Return the files with their stamps as they are on disk now."""
    return tuple(StampedFile(path, stamp_of(path)) for path in paths)


@dataclass(frozen=True)
class Origin:
    """The files that one frame of a shot is made of.

    frame     number of the plate that is read for it; for a scene, the frame itself
    is_black  True where only the size of that plate is used, and its pixels are replaced by black
    files     the file that is read, then the files that it names or that lie beside it;
              empty for the scene that comes with the program
    """

    frame: int
    is_black: bool = False
    files: tuple[StampedFile, ...] = ()
