"""Prepare every command after its words are parsed and before its work.

Depth networks are allowed or asked about, the frames of a movie are counted, and every output is
checked before the work, so that nobody waits for a picture that cannot be written.
"""

import argparse
import sys
from pathlib import Path

from heatlens.fronts.commands.output.pipes import DASH
from heatlens.media.files.atomic_file import check_output_path
from heatlens.media.files.picture_formats import parse_movie_name
from heatlens.media.plate.estimate.trusted import allow_all, set_question

# The options of all commands that name a file or a folder to write.
OUTPUT_OPTIONS = ("output", "behind_out", "edit_out", "difference", "plot", "shots", "bundle")
_WINDOW_COMMANDS = ("view", "serve")


def prepare(args: argparse.Namespace) -> None:
    """Prepare the command of `args`; raise InputError for an output that cannot be written."""
    _allow_networks(getattr(args, "run_networks", False), args.command in _WINDOW_COMMANDS)
    _count_movie_frames(args)
    _check_output_places(args)


def _allow_networks(runs_all: bool, is_window: bool) -> None:
    """Allow the depth networks of shots if `runs_all`; else ask about each one at the terminal.

    A command that opens a window asks nothing at the terminal.
    """
    if runs_all:
        allow_all()
    is_terminal = all(it is not None and it.isatty() for it in (sys.stdin, sys.stderr))
    if is_terminal and not is_window:
        set_question(_ask_at_terminal)


def _ask_at_terminal(question: str) -> bool:
    """Ask a question at the terminal; return True for the answer yes."""
    print(f"heatlens: {question} [y/N] ", end="", file=sys.stderr, flush=True)
    return sys.stdin.readline().strip().lower() in ("y", "yes")


def _count_movie_frames(args: argparse.Namespace) -> None:
    """Count the frames of a movie that is named in `args` from --first-frame."""
    first_frame = getattr(args, "first_frame", None)
    for name in ("plate", "shot"):
        text = getattr(args, name, None)
        movie = None if text is None else parse_movie_name(Path(text))
        if text is not None and movie is not None and first_frame is not None and first_frame >= 0:
            setattr(args, name, type(text)(f"{movie[0]}@{first_frame}"))
            args.first_frame = None


def _check_output_places(args: argparse.Namespace) -> None:
    """Raise InputError for an output in a place where nothing can be written.

    The frames of a job for a farm are written by other machines, whose disks may differ.
    """
    # `check_output_path` makes a file without a name, because access rights are not enough: in
    # /proc they allow writing, but nothing can be written. A study would find that after minutes.
    is_farm_job = getattr(args, "submit", None) is not None
    for name in OUTPUT_OPTIONS[is_farm_job:]:
        value = getattr(args, name, None)
        if isinstance(value, str | Path) and str(value) != DASH:
            check_output_path(Path(value).expanduser())
