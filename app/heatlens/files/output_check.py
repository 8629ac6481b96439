"""Check before the work begins whether an output can be written."""

import os
import shutil
from pathlib import Path

from heatlens.errors import InputError


def check_writable(path: Path) -> None:
    """Raise InputError if no file can be created in the folder of `path`, which must exist."""
    folder = path.parent
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"{path}: {folder} is not writable. Choose another folder.")


def check_space(folder: Path, need_bytes: float, what: str) -> None:
    """Raise InputError if the disk of `folder` has less free space than `what` will need.

    Nothing is refused if the free space is unknown.
    """
    try:
        free = shutil.disk_usage(folder).free
    except OSError:
        return
    if need_bytes > free:
        raise InputError(
            f"{folder}: {what} will need about {_size(need_bytes)}, and {_size(free)} are free on "
            "that disk. Free some, or choose another folder."
        )


def _size(count: float) -> str:
    for unit, name in ((1e9, "GB"), (1e6, "MB")):
        if count >= unit:
            return f"{count / unit:.1f} {name}"
    return f"{count / 1e3:.1f} kB"
