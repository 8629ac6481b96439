"""`heatlens shot`: a shot as a file, made and looked at without a window."""

import argparse

from heatlens.commands import shot_new, shot_show


def register(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add `shot new` and `shot show` to the command line."""
    parser = commands.add_parser(
        "shot",
        help="make a shot file, with keys and marks, or say what is in one",
        description="A shot is a plate seen through a lens that moves over frames.",
    )
    actions = parser.add_subparsers(dest="action", required=True, metavar="new|show")
    for action in (shot_new, shot_show):
        action.register(actions)
