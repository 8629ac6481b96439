"""Whether an output can be written, asked before the work and not after it."""

import os
import shutil
from pathlib import Path

from heatlens.errors import InputError


def check_writable(path: Path) -> None:
    """Raise InputError where no file may be made in the folder of `path`, which is there."""
    folder = path.parent
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"{path}: nothing may be written in {folder}. Choose another folder.")


def check_space(folder: Path, need_bytes: float, what: str) -> None:
    """Raise InputError where the disk of `folder` has less room than `what` will need.

    Where nobody says how much is free, nothing is refused.
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
