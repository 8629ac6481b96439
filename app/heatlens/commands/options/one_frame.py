"""Check that a command for one frame was not given a sequence or a folder."""

import os
from pathlib import Path

from heatlens.base.errors import InputError
from heatlens.sequence.names import parse_pattern


def check_one_frame(path: Path) -> None:
    """Raise InputError for a pattern or a folder; it names the command for these."""
    is_pattern = not os.path.exists(path) and parse_pattern(path.name) is not None
    if is_pattern or os.path.isdir(path):
        what = "a sequence" if is_pattern else "a folder"
        raise InputError(
            f"{path} is {what}: use `heatlens export` to render the frames of a sequence, or name "
            "one frame here."
        )
