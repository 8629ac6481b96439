r"""Paths that files name, also those that were written on another system.

A shot or an edit from Windows may name C:\plates\a.exr or \\server\share\a.exr. On another system
such a path keeps its drive or server, with slashes, until `--moved` says where its folder is.
"""

import os
import re
import sys
from pathlib import Path, PureWindowsPath
from urllib.parse import unquote, urlsplit

_DRIVE_OR_SERVER = re.compile(r"[A-Za-z]:[\\/]|\\\\")
_DRIVE = re.compile(r"[A-Za-z]:/")
_WINDOWS_MOST = 259  # characters of a path, unless the system's setting allows more


def path_in_folder(path: str, folder: str | os.PathLike[str]) -> str:
    """Return the absolute form of a path that a file in `folder` names."""
    if sys.platform != "win32" and _DRIVE_OR_SERVER.match(path):
        return PureWindowsPath(path).as_posix()
    return os.path.abspath(os.path.join(folder, path))


def path_of_url(url: str) -> str:
    """Return the path in a file URL: file:///C:/a is C:/a, file://server/share/a //server/share/a.

    A # belongs to the path: it stands for the digits of a frame.
    """
    parts = urlsplit(url.replace("#", "%23"))
    path = unquote(parts.path)
    if parts.netloc not in ("", "localhost"):
        return f"//{parts.netloc}{path}"
    return path[1:] if _DRIVE.match(path[1:]) else path


def path_note(path: Path) -> str:
    """Return a sentence on why a path may not be found on this system, after a space; else ""."""
    text = str(path)
    if sys.platform != "win32":
        is_foreign = _DRIVE.match(text) is not None
        return " It is a path of Windows: say where its folder is with --moved." * is_foreign
    if len(os.path.abspath(text)) <= _WINDOWS_MOST:
        return ""
    return (
        f" Its path has {len(os.path.abspath(text))} characters. Windows takes {_WINDOWS_MOST}, "
        "unless its setting LongPathsEnabled is on."
    )
