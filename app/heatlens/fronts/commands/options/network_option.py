"""`--run-networks`, and the question at a terminal that it saves."""

import sys

from heatlens.media.plate.estimate.trusted import ask_with, run_all


def allow_networks(runs_all: bool, is_window: bool) -> None:
    """Run the networks of shots if so asked for, else ask; a window asks nothing at a terminal."""
    if runs_all:
        run_all()
    is_terminal = all(it is not None and it.isatty() for it in (sys.stdin, sys.stderr))
    if is_terminal and not is_window:
        ask_with(_is_yes)


def _is_yes(question: str) -> bool:
    print(f"heatlens: {question} [y/N] ", end="", file=sys.stderr, flush=True)
    return sys.stdin.readline().strip().lower() in ("y", "yes")
