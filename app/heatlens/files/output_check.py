"""Check before the work begins whether an output can be written."""

import os
import shutil
from pathlib import Path

from heatlens.base.errors import InputError
from heatlens.base.stopping import folder_made


def check_folder(path: Path) -> None:
    """Raise InputError if the folder of `path` is missing, and the folder around it as well.

    `make_folder` makes one folder, but not several: a longer path that is missing is more often
    misspelt than new.
    """
    folder = path.parent
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{path}: there is no folder {folder}; that is a file.")
    if not folder.is_dir() and not folder.absolute().parent.is_dir():
        raise InputError(
            f"{path}: there is no folder {folder.parent}. heatlens makes one missing folder, "
            "not several."
        )


def make_folder(folder: Path, parents: bool = False) -> None:
    """Create the folder if it is missing, inside an existing one, or with its `parents`.

    Raises InputError.

    If the command is stopped, the folder is removed again unless it holds something.
    """
    try:
        if not folder.is_dir():
            folder_made(folder)
        folder.mkdir(exist_ok=True, parents=parents)
    except OSError as error:
        raise InputError(
            f"The folder {folder} cannot be made: {error.strerror or error}."
        ) from error


def check_writable(path: Path) -> None:
    """Raise InputError if no file can be created in the folder of `path`, which must exist."""
    folder = path.parent
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"{path}: {folder} is not writable. Choose another folder.")


def check_space(folder: Path, need_bytes: float, what: str) -> None:
    """Raise InputError if the disk of `folder` has less free space than `what` will need.

    A folder that will be made lies on the disk of the one around it. Nothing is refused if the free
    space is unknown, or if there is no disk.
    """
    try:
        disk = shutil.disk_usage(folder if folder.is_dir() else folder.parent)
    except OSError:
        return
    if disk.total and need_bytes > disk.free:
        raise InputError(
            f"{folder}: {what} will need about {_size(need_bytes)}, and {_size(disk.free)} are "
            "free on that disk. Free some, or choose another folder."
        )


def _size(count: float) -> str:
    for unit, name in ((1e9, "GB"), (1e6, "MB")):
        if count >= unit:
            return f"{count / unit:.1f} {name}"
    return f"{count / 1e3:.1f} kB"
