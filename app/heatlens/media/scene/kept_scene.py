"""Keep the scene that was read last: a command asks for it several times, and reads it once."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from heatlens.core.model.shot.framing import SceneTiming
from heatlens.media.sequence.sequence import StampedFile, stamp_files

if TYPE_CHECKING:  # the readers make it
    from heatlens.media.scene.scene import Scene

_LEAST_AGE_NS = 20_000_000  # two changes of a file in one tick of its clock have the same stamp


@dataclass(frozen=True, eq=False)
class _KeptScene:
    """A scene and all its files, its own first, with their stamps from when it was read."""

    path: Path
    timing: SceneTiming | None
    scene: "Scene"
    files: tuple[StampedFile, ...]

    def is_current(self) -> bool:
        """Return whether no file of the scene was changed, removed or added since."""
        return self.files == stamp_files(file.path for file in self.files)


_latest: list[_KeptScene] = []  # at most one


def read_or_kept(
    path: Path,
    timing: SceneTiming | None,
    read: Callable[[Path, SceneTiming | None], "Scene"],
    find_files: Callable[["Scene"], tuple[Path, ...]],
) -> "Scene":
    """Return the kept scene of this file and timing if its files are as they were; else read it.

    A scene is not kept if a file of it was changed shortly before or during the reading. Raises
    InputError as `read` does.
    """
    for kept in _latest:
        if (kept.path, kept.timing) == (path, timing) and kept.is_current():
            return kept.scene
    _latest.clear()
    begun_ns = time.time_ns()
    scene = read(path, timing)
    files = stamp_files((path, *find_files(scene)))
    stamps = [file.stamp for file in files if file.stamp is not None]
    if all(stamp[0] < begun_ns - _LEAST_AGE_NS for stamp in stamps):
        _latest[:] = [_KeptScene(path, timing, scene, files)]
    return scene


def kept_files(path: Path) -> tuple[Path, ...] | None:
    """Return the files of the kept scene, its own first; None if it is not kept or has changed."""
    for kept in _latest:
        if kept.path == path and kept.is_current():
            return tuple(file.path for file in kept.files)
    return None
