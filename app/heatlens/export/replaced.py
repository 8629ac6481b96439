"""Refuse an export that would replace files which no export of heatlens wrote."""

import os
from pathlib import Path

from heatlens.base.errors import InputError
from heatlens.export.finished import is_of_others
from heatlens.export.plan import ExportPlan


def check_replaced(plan: ExportPlan) -> None:
    """Raise InputError if files of others are in the place of frames and must not be replaced.

    Files of any earlier export are replaced without asking. So are empty files and files whose
    header cannot be read, because nothing can be lost.
    """
    if plan.job.options.overwrite:
        return
    paths = dict.fromkeys(frame.path for frame in plan.frames)
    others = [path for path in paths if _is_of_others(path)]
    if others:
        raise InputError(
            f"{_words(others, len(paths))} Choose another name or folder, or give --overwrite to "
            "replace what is there."
        )


def _is_of_others(path: Path) -> bool:
    return path.is_file() and os.path.getsize(path) > 0 and is_of_others(path)


def _words(others: list[Path], count: int) -> str:
    if count == 1:
        return f"{others[0]} is there already, and no export of heatlens wrote it."
    if len(others) == 1:
        return f"1 of the {count} files is there already, and no export wrote it: {others[0]}."
    return (
        f"{len(others)} of the {count} files are there already, and no export of heatlens wrote "
        f"them; {others[0]} is the first."
    )
