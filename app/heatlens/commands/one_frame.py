"""Commands that take one frame, told of many."""

import os
from pathlib import Path

from heatlens.errors import InputError
from heatlens.sequence.names import parse_pattern


def check_one_frame(path: Path) -> None:
    """Raise InputError for a pattern or a folder, and name the command that takes these."""
    is_pattern = not os.path.exists(path) and parse_pattern(path.name) is not None
    if is_pattern or os.path.isdir(path):
        what = "a sequence" if is_pattern else "a folder"
        raise InputError(
            f"{path} is {what}: `heatlens export` renders the frames of a sequence; here, name one "
            "of them."
        )
