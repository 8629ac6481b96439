"""Look whether every output of a command can be written, before the command begins its work."""

import argparse
from pathlib import Path

from heatlens.fronts.commands.output.pipes import DASH
from heatlens.media.files.atomic_file import check_place

# The options of all commands that name a file or a folder to write.
OUTPUTS = ("output", "behind_out", "edit_out", "difference", "plot", "shots", "bundle")


def check_output_places(args: argparse.Namespace) -> None:
    """Raise InputError for an output in a place where nothing can be written.

    The frames of a job for a farm are written by other machines, whose disks may differ.
    """
    is_elsewhere = getattr(args, "submit", None) is not None
    for name in OUTPUTS[is_elsewhere:]:
        value = getattr(args, name, None)
        if isinstance(value, str | Path) and str(value) != DASH:
            check_place(Path(value).expanduser())
