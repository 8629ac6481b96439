"""Test that every option that takes a value accepts one that begins with a minus.

The options are found in the parsers: one that is added is tried too.
"""

import argparse
import os
import subprocess
import sys

import pytest

from heatlens.core.base.errors import InputError
from heatlens.fronts.commands.command_parser import build_parser
from heatlens.fronts.commands.main import main
from heatlens.fronts.commands.options.value_types import (
    parse_f_number,
    parse_millimeters,
    parse_number,
    parse_whole_number,
)
from heatlens.media.sequence.names import parse_frames

VALUES = ("-2-1", "-2--1", "-70,50", "-5", "-.5", "-clip.exr", "-1001-1100x2")


def parsers(parser):
    """Yield the words that call each command, and the command's parser."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, inner in action.choices.items():
                yield name, inner
                yield from (
                    (f"{name} {subcommand}", subparser) for subcommand, subparser in parsers(inner)
                )


COMMANDS = list(parsers(build_parser()))


def options_with_values(parser):
    """Yield the options of a parser that take values; --help ends the program."""
    for action in parser._actions:
        if action.option_strings and action.nargs != 0 and action.dest != "help":
            yield action


@pytest.mark.parametrize(("command", "parser"), COMMANDS, ids=[name for name, _ in COMMANDS])
def test_every_option_accepts_value_that_begins_with_minus(command, parser):
    for group in parser._mutually_exclusive_groups:
        group.required = False
    for action in parser._actions:  # what a value means is tried elsewhere
        action.required = False
        action.type = action.choices = None
        if not action.option_strings and not isinstance(action, argparse._SubParsersAction):
            action.nargs = "*"
    for action in options_with_values(parser):
        for option in action.option_strings:
            for value in VALUES[: 5 if action.nargs is not None else None]:
                count = action.nargs if isinstance(action.nargs, int) else 1
                if isinstance(action, argparse._SubParsersAction):
                    continue
                arguments = parser.parse_known_args([option, *[value] * count])[0]
                assert value in str(getattr(arguments, action.dest)), (command, option, value)


def test_option_is_not_taken_as_value_of_another(capsys):
    with pytest.raises(SystemExit):
        main(["render", "plate.exr", "--output", "--f-stop", "2"])
    assert "expected one argument" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["render", "plate.exr", "-o", "-q"])
    assert "expected one argument" in capsys.readouterr().err


def test_parse_frames_rejects_backward_ranges_without_step():
    assert parse_frames("-2--1,3") == (-2, -1, 3)
    assert parse_frames("1004-998x-3") == (998, 1001, 1004)  # told by its step
    for text in ("1100-1001", "1,9-7", "-1--2"):
        with pytest.raises(InputError, match="backwards"):
            parse_frames(text)


def test_number_parsers_read_full_width_digits_and_units(capsys):
    assert (
        parse_whole_number("１２"),
        parse_number("２．５"),
        parse_f_number("f ƒ/1.4"),
        parse_f_number("ｆ／２"),
    ) == (12, 2.5, 1.4, 2)
    assert parse_millimeters("5cm") == 50.0
    with pytest.raises(argparse.ArgumentTypeError, match="Did you mean 50mm"):
        parse_millimeters("50m")


PRINTING = [
    ("--print-completion", "bash"),
    ("--help",),
    ("--version",),
    ("render", "--help"),  # that of all commands is printed by the same lines
    ("shot", "show", "--help"),
    ("kits",),
    ("info", "--json", "assets/still_life.exr"),
]


@pytest.mark.parametrize("words", PRINTING, ids=" ".join)
def test_printing_commands_survive_closed_pipe(words):
    """The pipe for the output is closed before anything is written, as with `| head -0`."""
    read_end, write_end = os.pipe()
    os.close(read_end)
    code = (
        "import sys; from heatlens.fronts.commands.main import main; sys.exit(main(sys.argv[1:]))"
    )
    process = subprocess.run(
        [sys.executable, "-c", code, *words],
        stdout=write_end,
        stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONUNBUFFERED": ""},
        check=False,
    )
    os.close(write_end)
    assert process.stderr == b"" and process.returncode in (0, 141)  # argparse prints help itself
