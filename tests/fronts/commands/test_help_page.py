"""Test `--help`: one screen of what most users need, and the way to every other option."""

import argparse
import re
from collections.abc import Iterator

import pytest

from heatlens.fronts.commands.command_parser import build_parser
from heatlens.fronts.commands.main import main
from heatlens.fronts.commands.output.help_page import _COMMON_OPTIONS, WHOLE, page_of


def leaf_commands(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """Yield the parsers of all commands that have no commands of their own."""
    nested = [it for it in parser._actions if isinstance(it, argparse._SubParsersAction)]
    if not nested:
        yield parser
    for command in nested[0].choices.values() if nested else ():
        yield from leaf_commands(command)


PARSERS = {
    parser.prog.removeprefix("heatlens "): parser for parser in leaf_commands(build_parser())
}


def long_options(parser: argparse.ArgumentParser) -> set[str]:
    shown = [it for it in parser._actions if it.help != argparse.SUPPRESS]
    return {word for it in shown for word in it.option_strings if word[:2] == "--"}


def options_in(text: str) -> set[str]:
    return set(re.findall(r"--[a-z][a-z0-9-]*", text))


def printed(capsys, *words: str) -> str:
    with pytest.raises(SystemExit) as end:
        main(list(words))
    assert end.value.code == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("name", PARSERS)
def test_help_of_command_fits_one_screen(name):
    most_lines = 45 if name in ("render", "view") else 60
    assert len(page_of(PARSERS[name]).splitlines()) <= most_lines


def test_help_of_the_program_fits_one_screen():
    assert len(build_parser(()).format_help().splitlines()) <= 60


@pytest.mark.parametrize("name", PARSERS)
def test_help_all_lists_every_option(name):
    assert long_options(PARSERS[name]) <= options_in(page_of(PARSERS[name], WHOLE))


@pytest.mark.parametrize("name", ["view", "render", "export", "shot new", "reel", "study", "bench"])
def test_groups_named_by_short_help_list_every_option(name):
    short = page_of(PARSERS[name])
    listed = short.partition("more options: ")[2].partition("\n\n")[0]
    groups = re.findall(r"^  (\S+)", listed, re.MULTILINE)
    pages = "".join(page_of(PARSERS[name], group) for group in groups)
    assert long_options(PARSERS[name]) <= options_in(pages)


def test_every_common_option_belongs_to_a_command():
    assert set().union(*map(long_options, PARSERS.values())) >= _COMMON_OPTIONS


def test_unknown_group_is_refused_with_the_names_of_the_groups(capsys):
    with pytest.raises(SystemExit) as end:
        main(["render", "--help", "lense"])
    message = capsys.readouterr().err
    assert end.value.code == 2 and "'lense'" in message and "look, lens, blur" in message


def test_help_can_be_asked_for_before_and_after_the_command(capsys):
    pages = {printed(capsys, *words.split()) for words in ("render -h", "--help render")}
    assert pages == {printed(capsys, "help", "render")}
    assert "--blades" in printed(capsys, "render", "--help", "lens")
    assert "--blades" in printed(capsys, "render", "--help-all")
