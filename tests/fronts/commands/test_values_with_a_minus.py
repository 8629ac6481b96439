"""A value that begins with a minus is a value, after every option of every command that takes one.

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
from heatlens.fronts.commands.options.value_types import f_number, millimetres, number, whole
from heatlens.media.sequence.names import parse_frames

VALUES = ("-2-1", "-2--1", "-70,50", "-5", "-.5", "-clip.exr", "-1001-1100x2")


def parsers(parser):
    """Yield every command's parser, with the words that call it."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, inner in action.choices.items():
                yield name, inner
                yield from ((f"{name} {more}", it) for more, it in parsers(inner))


COMMANDS = list(parsers(build_parser()))


def taking(parser):
    """Return the options that take values, with how many."""
    for action in parser._actions:
        if action.option_strings and action.nargs != 0:
            yield action


@pytest.mark.parametrize(("command", "parser"), COMMANDS, ids=[name for name, _ in COMMANDS])
def test_a_value_may_begin_with_a_minus(command, parser):
    for group in parser._mutually_exclusive_groups:
        group.required = False
    for action in parser._actions:  # what a value means is tried elsewhere
        action.required = False
        action.type = action.choices = None
        if not action.option_strings and not isinstance(action, argparse._SubParsersAction):
            action.nargs = "*"
    for action in taking(parser):
        for option in action.option_strings:
            for value in VALUES[: 5 if action.nargs is not None else None]:
                count = action.nargs if isinstance(action.nargs, int) else 1
                if isinstance(action, argparse._SubParsersAction):
                    continue
                found = parser.parse_known_args([option, *[value] * count])[0]
                assert value in str(getattr(found, action.dest)), (command, option, value)


def test_an_option_is_no_value(capsys):
    with pytest.raises(SystemExit):
        main(["render", "plate.exr", "--output", "--f-stop", "2"])
    assert "expected one argument" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["render", "plate.exr", "-o", "-q"])
    assert "expected one argument" in capsys.readouterr().err


def test_frames_that_run_backwards_are_refused():
    assert parse_frames("-2--1,3") == (-2, -1, 3)
    assert parse_frames("1004-998x-3") == (998, 1001, 1004)  # told by its step
    for text in ("1100-1001", "1,9-7", "-1--2"):
        with pytest.raises(InputError, match="backwards"):
            parse_frames(text)


def test_numbers_in_full_width_and_a_lens_of_metres(capsys):
    assert (whole("１２"), number("２．５"), f_number("f ƒ/1.4"), f_number("ｆ／２")) == (
        12,
        2.5,
        1.4,
        2,
    )
    assert millimetres("5cm") == 50.0
    with pytest.raises(argparse.ArgumentTypeError, match="Did you mean 50mm"):
        millimetres("50m")


PRINTING = [
    ("--print-completion", "bash"),
    ("--help",),
    ("--version",),
    *((*command.split(), "--help") for command, _ in COMMANDS),
    ("kits",),
    ("info", "--json", "assets/still_life.exr"),
]


@pytest.mark.parametrize("words", PRINTING, ids=" ".join)
def test_a_reader_who_goes_is_no_fault(words):
    """Nobody reads the output at all, as after `| head -0`."""
    read, write = os.pipe()
    os.close(read)
    code = (
        "import sys; from heatlens.fronts.commands.main import main; sys.exit(main(sys.argv[1:]))"
    )
    ended = subprocess.run(
        [sys.executable, "-c", code, *words],
        stdout=write,
        stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONUNBUFFERED": ""},
        check=False,
    )
    os.close(write)
    assert ended.stderr == b"" and ended.returncode in (0, 141)  # argparse prints help itself
