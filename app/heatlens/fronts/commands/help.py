"""`heatlens help WORD ...`: find options, keys and sections of the manual by words."""

import argparse
import textwrap

from heatlens.core.base.errors import InputError
from heatlens.core.base.manual_search import Passage, best_passages, manual_passages
from heatlens.core.model.option import suggest_similar
from heatlens.fronts.commands.command_parser import build_parser
from heatlens.fronts.commands.command_table import COMMANDS

DESCRIPTION = """\
Searches the manual, which needs no network, and prints the options, keys and sections that fit
best. The name of a command prints its help instead."""
EPILOG = """\
examples:
  heatlens help overwrite
  heatlens help unit of a table
  heatlens help render
"""
_SHOT_COMMANDS = ("shot new", "shot show", "shot sheet", "shot size")
_MOST_HITS = 8
_MOST_CHARACTERS = 220  # of a passage that is printed


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the words."""
    parser.add_argument("words", nargs="*", metavar="WORD", help="what to look for")


def run(args: argparse.Namespace) -> int:
    """Print the help of a command, or the passages of the manual that fit the words best.

    Without words it prints the help of the program. Raises InputError if nothing fits.
    """
    if not args.words:
        build_parser(()).print_help()
        return 0
    if " ".join(args.words) in (*COMMANDS, *_SHOT_COMMANDS):
        build_parser(args.words[:1]).parse_args([*args.words, "--help"])  # ends the process
    hits = best_passages(manual_passages(has_references=True), " ".join(args.words), _MOST_HITS)
    if not hits:
        raise InputError(
            f"There is no command and nothing in the manual about {' '.join(args.words)!r}."
            f"{suggest_similar(args.words[0], COMMANDS) or ' Try other words.'}"
        )
    print("\n\n".join(_text_of(it) for it in hits))
    return 0


def _text_of(passage: Passage) -> str:
    """Return a passage as it is printed: where it stands, and its beginning."""
    text = passage.shortened(_MOST_CHARACTERS)
    return f"{passage.place}\n{textwrap.indent(textwrap.fill(text, 96), '  ')}"
