"""The option that chooses which GPU draws, for the commands that open no window."""

import argparse

from heatlens.core.base.errors import InputError
from heatlens.fronts.commands.options.value_types import wholes
from heatlens.render.gpu.context import choose_device


def add_device_option(group: "argparse._ActionsContainer", has_processes: bool = False) -> None:
    """Add which GPU draws; several for a command that `has_processes`."""
    several = "; several share the --processes" if has_processes else ""
    group.add_argument(
        "--device",
        type=wholes,
        default=(),
        metavar="N[,N]" if has_processes else "N",
        help=f"GPU to render with, as EGL counts them from 0{several}",
    )


def use_device(args: argparse.Namespace) -> None:
    """Render with the first of --device. Raises InputError if there are more than processes."""
    count, processes = len(args.device), getattr(args, "processes", 1) or 1
    if count > processes:
        more = "give one" if not hasattr(args, "processes") else f"give --processes {count} or more"
        raise InputError(f"--device names {count} devices: {more}.")
    if args.device:
        choose_device(args.device[0])
