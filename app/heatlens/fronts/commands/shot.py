"""`heatlens shot`: make and show shot files without a window."""

import argparse

from heatlens.fronts.commands.command_parser import add_command
from heatlens.fronts.commands.shots import shot_new, shot_sheet, shot_show, shot_size

_ACTIONS = (*(("new", shot_new), ("show", shot_show), ("sheet", shot_sheet), ("size", shot_size)),)
DESCRIPTION = "A shot is a plate seen through a lens that moves over frames."


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the actions of the command: new, show, sheet and size."""
    actions = parser.add_subparsers(dest="action", required=True, metavar="new|show|sheet|size")
    for name, module in _ACTIONS:
        add_command(actions, name, module.HELP, module)
