"""Paths in a file that names others: relative to its folder, so that they move together."""

import os
from pathlib import Path


def path_beside(path: str, folder: str | os.PathLike[str]) -> str:
    """Return the path relative to the folder of a file, or absolute where they share none."""
    absolute = os.path.abspath(path)
    try:
        shared = os.path.commonpath([absolute, os.path.abspath(folder)])
    except ValueError:  # on two drives
        return absolute
    if shared == os.path.dirname(shared):
        return absolute
    return Path(os.path.relpath(absolute, folder)).as_posix()


def path_from(path: str, folder: str | os.PathLike[str]) -> str:
    """Return a path that a file in `folder` names as an absolute one."""
    return os.path.abspath(os.path.join(folder, path))
