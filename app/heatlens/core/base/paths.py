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
from heatlens.core.base.named_paths import path_note

FILE_MOST_BYTES = 16_000_000_000  # larger ones do not fit the memory of a usual machine
_SIMILARITY_LEAST = 0.8  # how alike two names are that differ by a slip of the fingers, of 1
_PACKAGE = Path(__file__).resolve().parents[2]


def home_dir() -> Path:
    """Return the user's home, or the root folder for a user who has none, as in a container."""
    home = os.path.expanduser("~")
    return Path(os.sep if home == "~" else home)


def pictures_dir() -> Path:
    """Return the user's folder of pictures, else the home folder."""
    home = home_dir()
    configured = os.environ.get("XDG_PICTURES_DIR")
    folder = Path(configured) if configured else home / "Pictures"
    return folder if folder.is_dir() else home


def folder_to_write_in(path: Path) -> Path:
    """Return the folder in which to write files that belong to the file at `path`.

    This is the folder of the file itself; or the user's folder of pictures if the file is an asset
    of the program, or if its folder is not writable.
    """
    own_folder = path.absolute().parent
    is_asset = own_folder.resolve() == data_dir("assets").resolve()
    return pictures_dir() if is_asset or not os.access(own_folder, os.W_OK) else own_folder


def unreadable_error(path: Path, error: OSError | None = None) -> InputError:
    """Return the error for a file that cannot be opened."""
    if os.path.isdir(path):  # raises nothing, unlike Path.is_dir of a name that is too long
        return InputError(f"{path} is a folder, not a file.")
    if not os.path.lexists(path):
        return InputError(f"{path} is not there.{path_note(path) or _suggest_similar_name(path)}")
    reason = (error.strerror or str(error)) if error is not None else "it is not a file"
    return InputError(f"{path} cannot be read: {reason}.")


def _suggest_similar_name(path: Path) -> str:
    """Return " Did you mean X?" for a file in the same folder with a similar name, else ""."""
    try:
        names = sorted(os.listdir(path.parent))
    except OSError:
        return ""
    similar_names = get_close_matches(path.name, names, 1, _SIMILARITY_LEAST)
    return f" Did you mean {path.with_name(similar_names[0])}?" if similar_names else ""


def absolute(path: str | os.PathLike[str]) -> str:
    """Return an absolute path or pattern without `..` and `~`; links are not resolved."""
    return os.path.abspath(os.path.expanduser(path))


def read_file_bytes(path: Path, most: int = FILE_MOST_BYTES) -> bytes:
    """Return the content of a file, of at most `most` bytes.

    Raises OSError for a larger one, and as `open_regular_file` does.
    """
    return read_file_and_status(path, most)[0]


def read_file_and_status(path: Path, most: int = FILE_MOST_BYTES) -> tuple[bytes, os.stat_result]:
    """Return the content and the status of the same opened file.

    Raises OSError as `read_file_bytes` does.
    """
    with open_regular_file(path) as file:
        status = os.fstat(file.fileno())
        if status.st_size > most:
            raise OSError(
                errno.EFBIG,
                f"it has more than the {most / 1e6:.0f} MB that heatlens reads",
                str(path),
            )
        return file.read(), status


def is_of_user_alone(status: os.stat_result) -> bool:
    """Return True if only this user owns and can access a file; always True on Windows."""
    if sys.platform == "win32":
        return True
    access_of_others = status.st_mode & (stat.S_IRWXG | stat.S_IRWXO)
    return status.st_uid == os.getuid() and not access_of_others


def open_regular_file(path: Path) -> BinaryIO:
    """Open a file to read it; raise OSError for a pipe or a device, which may never end.

    All files are opened for reading here (`tests/media/files/test_guarded_reading.py`).
    """
    # Opening a pipe that nobody writes to must not block. The status is that of the open file,
    # because another file could take its name between a check and the reading.
    descriptor = os.open(
        path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    )
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        is_folder = stat.S_ISDIR(os.fstat(descriptor).st_mode)
        os.close(descriptor)
        error_number = errno.EISDIR if is_folder else errno.EINVAL
        raise OSError(
            error_number, "it is a folder" if is_folder else "it is not a file", str(path)
        )
    return open(descriptor, "rb")


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


def manual_pages() -> tuple[Path, ...]:
    """Return the pages of the manual: in a wheel below the package, in a checkout beside it."""
    folders = (_PACKAGE / "manual", _PACKAGE.parent / "manual")
    pages = (path for folder in folders for path in folder.glob("*.md"))
    return tuple(sorted(path for path in pages if path.name != "README.md"))  # the contents


_NAME = "heatlens"
_IS_LINUX = sys.platform.startswith("linux")


def preferences_dir() -> Path:
    """Return the folder of the preferences; on Linux `~/.config/heatlens`."""
    dirs = PlatformDirs(_NAME, appauthor=False, roaming=True)
    return _configured_dir("HEATLENS_CONFIG_DIR", lambda: dirs.user_config_dir)


def kits_dir() -> Path:
    """Return the folder of the user's own lens kits; on Linux `~/.config/heatlens/kits`."""
    return preferences_dir() / "kits"


def rendered_frames_dir() -> Path:
    """Return the cache folder of rendered frames; on Linux `~/.cache/heatlens/frames`."""
    dirs = PlatformDirs(_NAME, appauthor=False)
    return _configured_dir("HEATLENS_CACHE_DIR", lambda: dirs.user_cache_dir) / "frames"


def compiled_shaders_dir() -> Path:
    """Return the cache folder of compiled shaders; on Linux `~/.cache/heatlens/shaders`."""
    return rendered_frames_dir().with_name("shaders")


def estimates_dir() -> Path:
    """Return the cache folder of estimated depths, beside that of rendered frames."""
    return rendered_frames_dir().with_name("estimates")


def runtime_dir() -> Path:
    """Return the folder for files of a running window; on Linux `/run/user/UID/heatlens`."""
    dirs = PlatformDirs(_NAME, appauthor=False)

    def usual() -> str:
        """Return the folder that the system has for files of running programs."""
        with warnings.catch_warnings():
            warnings.simplefilter(
                "ignore"
            )  # platformdirs warns if a login has no runtime folder and uses /tmp
            return dirs.user_runtime_dir

    return _configured_dir("HEATLENS_RUNTIME_DIR", usual)


def reports_dir() -> Path:
    """Return the folder of the fault reports; on Linux `~/.local/state/heatlens`."""
    # On Linux platformdirs would add "log", but earlier versions wrote reports one level higher.
    dirs = PlatformDirs(_NAME, appauthor=False, opinion=not _IS_LINUX)
    return _configured_dir("HEATLENS_LOG_DIR", lambda: dirs.user_log_dir)


def _configured_dir(variable: str, default_dir: Callable[[], str]) -> Path:
    """Return the folder that an environment variable names, else the usual one of the system."""
    configured = os.environ.get(variable)
    if configured:
        return Path(configured)
    try:
        return Path(default_dir())
    except (RuntimeError, OSError):  # no home, as in a container; or others took the folder's name
        return home_dir() / f".{_NAME}"
