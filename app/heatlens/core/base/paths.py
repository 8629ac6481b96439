"""Find shaders and assets, beside the package (wheel) or at the top of a checkout, and folders.

This module also makes the error for a file that cannot be opened.

The folders of the user are where heatlens keeps its own files: preferences, cache and reports.
`platformdirs` knows the folders of each system. Environment variables override them:
HEATLENS_CONFIG_DIR, HEATLENS_CACHE_DIR, HEATLENS_RUNTIME_DIR and HEATLENS_LOG_DIR.
"""

import errno
import os
import stat
import sys
import warnings
from collections.abc import Callable
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import BinaryIO

from platformdirs import PlatformDirs

from heatlens.core.base.errors import InputError

FILE_MOST_BYTES = 16_000_000_000  # larger ones do not fit the memory of a usual machine
_ALIKE = 0.8  # how alike two names are that differ by a slip of the fingers, of 1
_PACKAGE = Path(__file__).resolve().parents[2]


def home_dir() -> Path:
    """Return the user's home, or the root folder for a user who has none, as in a container."""
    home = os.path.expanduser("~")
    return Path(os.sep if home == "~" else home)


def pictures_dir() -> Path:
    """Return the user's folder of pictures, else the home folder."""
    home = home_dir()
    named = os.environ.get("XDG_PICTURES_DIR")
    folder = Path(named) if named else home / "Pictures"
    return folder if folder.is_dir() else home


def folder_to_write_in(path: Path) -> Path:
    """Return the folder of a file, to write other files beside it.

    Return the user's folder of pictures if the file comes with the program, or if nothing may be
    written beside it.
    """
    beside = path.absolute().parent
    is_own = beside.resolve() == data_dir("assets").resolve()
    return pictures_dir() if is_own or not os.access(beside, os.W_OK) else beside


def unreadable(path: Path, error: OSError | None = None) -> InputError:
    """Return the error for a file that cannot be opened."""
    if os.path.isdir(path):  # raises nothing, unlike Path.is_dir of a name that is too long
        return InputError(f"{path} is a folder, not a file.")
    if not os.path.lexists(path):
        return InputError(f"{path} is not there.{_meant_beside(path)}")
    why = (error.strerror or str(error)) if error is not None else "it is not a file"
    return InputError(f"{path} cannot be read: {why}.")


def _meant_beside(path: Path) -> str:
    """Return " Did you mean X?" for a file in the same folder with a similar name, else ""."""
    try:
        names = sorted(os.listdir(path.parent))
    except OSError:
        return ""
    near = get_close_matches(path.name, names, 1, _ALIKE)
    return f" Did you mean {path.with_name(near[0])}?" if near else ""


def absolute(path: str | os.PathLike[str]) -> str:
    """Return an absolute path or pattern without `..` and `~`; links are not resolved."""
    return os.path.abspath(os.path.expanduser(path))


def file_bytes(path: Path, most: int = FILE_MOST_BYTES) -> bytes:
    """Return the content of a file, of at most `most` bytes.

    Raises OSError for a larger one, and as `opened_file` does.
    """
    return file_and_status(path, most)[0]


def file_and_status(path: Path, most: int = FILE_MOST_BYTES) -> tuple[bytes, os.stat_result]:
    """Return the content and the status of the same opened file; raises OSError as `file_bytes`."""
    with opened_file(path) as file:
        status = os.fstat(file.fileno())
        if status.st_size > most:
            raise OSError(errno.EFBIG, f"it has more than {most / 1e6:.0f} MB", str(path))
        return file.read(), status


def opened_file(path: Path) -> BinaryIO:
    """Open a file to read it; raise OSError for a pipe or a device, which may never end.

    All files are opened for reading here (`tests/media/files/test_guarded_reading.py`).
    """
    # Opening a pipe that nobody writes to must not block. The status is that of the open file,
    # because another file could take its name between a check and the reading.
    opened = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    if not stat.S_ISREG(os.fstat(opened).st_mode):
        is_folder = stat.S_ISDIR(os.fstat(opened).st_mode)
        os.close(opened)
        kind = errno.EISDIR if is_folder else errno.EINVAL
        raise OSError(kind, "it is a folder" if is_folder else "it is not a file", str(path))
    return open(opened, "rb")


@cache
def data_dir(name: str) -> Path:
    """Return the folder `shaders` or `assets`, in a wheel or a checkout.

    importlib.resources cannot see the top level of a checkout.
    """
    for parent in (_PACKAGE, _PACKAGE.parents[1]):
        if (parent / name).is_dir():
            return parent / name
    raise InputError(
        f"heatlens is not installed completely: there is no folder {name!r} beside {_PACKAGE} or "
        "two folders up. Install it again with pip."
    )


_NAME = "heatlens"
_IS_LINUX = sys.platform.startswith("linux")


def preferences_dir() -> Path:
    """Return the folder of the preferences; on Linux `~/.config/heatlens`."""
    dirs = PlatformDirs(_NAME, appauthor=False, roaming=True)
    return _chosen("HEATLENS_CONFIG_DIR", lambda: dirs.user_config_dir)


def kits_dir() -> Path:
    """Return the folder of the user's own lens kits; on Linux `~/.config/heatlens/kits`."""
    return preferences_dir() / "kits"


def rendered_frames_dir() -> Path:
    """Return the cache folder of rendered frames; on Linux `~/.cache/heatlens/frames`."""
    dirs = PlatformDirs(_NAME, appauthor=False)
    return _chosen("HEATLENS_CACHE_DIR", lambda: dirs.user_cache_dir) / "frames"


def estimates_dir() -> Path:
    """Return the cache folder of estimated depths, beside that of rendered frames."""
    return rendered_frames_dir().with_name("estimates")


def runtime_dir() -> Path:
    """Return the folder for files of a running window; on Linux `/run/user/UID/heatlens`."""
    dirs = PlatformDirs(_NAME, appauthor=False)

    def usual() -> str:
        with warnings.catch_warnings():
            warnings.simplefilter(
                "ignore"
            )  # platformdirs warns if a login has no runtime folder and uses /tmp
            return dirs.user_runtime_dir

    return _chosen("HEATLENS_RUNTIME_DIR", usual)


def reports_dir() -> Path:
    """Return the folder of the fault reports; on Linux `~/.local/state/heatlens`."""
    # On Linux platformdirs would add "log", but earlier versions wrote reports one level higher.
    dirs = PlatformDirs(_NAME, appauthor=False, opinion=not _IS_LINUX)
    return _chosen("HEATLENS_LOG_DIR", lambda: dirs.user_log_dir)


def _chosen(variable: str, usual: Callable[[], str]) -> Path:
    """Return the folder that an environment variable names, else the usual one of the system."""
    chosen = os.environ.get(variable)
    if chosen:
        return Path(chosen)
    try:
        return Path(usual())
    except (RuntimeError, OSError):  # no home, as in a container; or others took the folder's name
        return home_dir() / f".{_NAME}"
