"""`heatlens shot`: make and show shot files without a window."""

import argparse

from heatlens.commands.shots import shot_new, shot_sheet, shot_show


def register(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add `shot new`, `shot show` and `shot sheet` to the command line."""
    parser = commands.add_parser(
        "shot",
        help="make a shot file with keys and marks, show its contents, or write its pull sheet",
        description="A shot is a plate seen through a lens that moves over frames.",
    )
    actions = parser.add_subparsers(dest="action", required=True, metavar="new|show|sheet")
    for action in (shot_new, shot_show, shot_sheet):
        action.register(actions)
