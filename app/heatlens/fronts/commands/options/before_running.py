"""What every command does between reading its words and its work.

Depth networks are allowed or asked about, the frames of a movie are counted, and every output is
looked at, so that nobody waits for a picture that cannot be written.
"""

import argparse
import sys
from pathlib import Path

from heatlens.fronts.commands.output.pipes import DASH
from heatlens.media.files.atomic_file import check_place
from heatlens.media.files.picture_formats import movie_named
from heatlens.media.plate.estimate.trusted import ask_with, run_all

# The options of all commands that name a file or a folder to write.
OUTPUTS = ("output", "behind_out", "edit_out", "difference", "plot", "shots", "bundle")
_WINDOWS = ("view", "serve")


def prepare(args: argparse.Namespace) -> None:
    """Prepare the command of `args`; raise InputError for an output that cannot be written."""
    _allow_networks(getattr(args, "run_networks", False), args.command in _WINDOWS)
    _count_movie_frames(args)
    _check_output_places(args)


def _allow_networks(runs_all: bool, is_window: bool) -> None:
    """Run the networks of shots if so asked for, else ask; a window asks nothing at a terminal."""
    if runs_all:
        run_all()
    is_terminal = all(it is not None and it.isatty() for it in (sys.stdin, sys.stderr))
    if is_terminal and not is_window:
        ask_with(_is_yes)


def _is_yes(question: str) -> bool:
    print(f"heatlens: {question} [y/N] ", end="", file=sys.stderr, flush=True)
    return sys.stdin.readline().strip().lower() in ("y", "yes")


def _count_movie_frames(args: argparse.Namespace) -> None:
    """Count the frames of a movie that is named in `args` from --first-frame."""
    first = getattr(args, "first_frame", None)
    for name in ("plate", "shot"):
        text = getattr(args, name, None)
        movie = None if text is None else movie_named(Path(text))
        if text is not None and movie is not None and first is not None and first >= 0:
            setattr(args, name, type(text)(f"{movie[0]}@{first}"))
            args.first_frame = None


def _check_output_places(args: argparse.Namespace) -> None:
    """Raise InputError for an output in a place where nothing can be written.

    The frames of a job for a farm are written by other machines, whose disks may differ.
    """
    # A study worked for minutes before it found that nothing can be written in /proc, whose rights
    # say otherwise: so a file without a name is made there, which is more than to ask for rights.
    is_elsewhere = getattr(args, "submit", None) is not None
    for name in OUTPUTS[is_elsewhere:]:
        value = getattr(args, name, None)
        if isinstance(value, str | Path) and str(value) != DASH:
            check_place(Path(value).expanduser())
