"""Prepare the words of a command line for parsing, and suggest corrections for wrong ones."""

import argparse
import difflib
import os
from collections.abc import Sequence

from heatlens.base.errors import InputError
from heatlens.model.other_names import OTHER_NAMES

_QUIET = ("-q", "--quiet")
_ABOUT_ALL = ("-h", "--help", "-V", "--version", "--print-completion")
_CAMERA_SUFFIXES = (".usd", ".usda", ".usdc", ".json", ".csv")
# What people type who come from other programs.
_OTHER_NAMES = {f"--{other}": f"--{own}" for other, own in OTHER_NAMES.items()}


def with_command(argv: Sequence[str], commands: Sequence[str]) -> list[str]:
    """Put the command first: `view` where none is named, and help as the option that it is.

    Raises InputError for a word that is nearly a command, and no file.
    """
    words = list(argv)
    if not words:
        return ["view"]
    first, rest = words[0], words[1:]
    if first in _QUIET:
        command, *others = with_command(rest, commands)
        return [command, first, *others]
    if first in (*commands, *_ABOUT_ALL):
        return words
    if first in ("help", "version") and not os.path.exists(first):
        if first == "help" and rest and rest[0] not in commands:
            raise InputError(f"There is no command {rest[0]!r}{_near(rest[0], commands)}")
        return [*rest, "--help"] if first == "help" else ["--version"]
    near = difflib.get_close_matches(first, commands, 1)
    if near and not os.path.exists(first):
        raise InputError(f"There is no command or file {first!r}. Did you mean {near[0]}?")
    return ["view", *words]


def _near(word: str, commands: Sequence[str]) -> str:
    """Return the end of a sentence: the command that is like `word`, else all that there are."""
    near = difflib.get_close_matches(word, commands, 1)
    return f". Did you mean {near[0]}?" if near else f"; there are {', '.join(commands)}."


def is_name_elsewhere(option: str) -> bool:
    """Return True for an option of other programs that is called something else here.

    "--aperture" is one, although it is also the beginning of --aperture-image.
    """
    name = option.partition("=")[0]
    return not _OTHER_NAMES.get(name, name).startswith(name)


def _elsewhere(option: str, value: str, prog: str) -> str:
    """Return the end of a sentence on the command that takes an option, "" where none is known."""
    is_file = os.path.splitext(value)[1].lower() in _CAMERA_SUFFIXES
    if option == "--lens-from" or (option == "--camera" and is_file):
        return f". {option} gives the lens of a file to `heatlens shot new` and `heatlens view`."
    if prog.endswith(" camera") and option in _lens_flags():
        return f". The lens is that of the shot: `heatlens shot new` takes {option}."
    return ""


def _lens_flags() -> set[str]:
    from heatlens.commands.options.lens_options import add_lens_options  # slow, and seldom needed

    parser = argparse.ArgumentParser(add_help=False)
    add_lens_options(parser)
    return set(parser._option_string_actions)


def meant(unknown: Sequence[str], parser: argparse.ArgumentParser) -> str:
    """Return ". Did you mean --f-stop?" for a wrong option that is like one there is, else "".

    An option that another command takes is answered with that command.
    """
    known = [name for name in parser._option_string_actions if name.startswith("--")]
    for word, after in zip(unknown, (*unknown[1:], ""), strict=True):
        option, _, value = word.partition("=")
        if not option.startswith("--"):
            continue
        if elsewhere := _elsewhere(option, value or after, parser.prog):
            return elsewhere
        other = _OTHER_NAMES.get(option)
        near = [other] if other in known else difflib.get_close_matches(option, known, 1)
        if near == ["--focus-distance"] and "--focus-at" in known:
            near = ["--focus-distance or --focus-at"]
        if near:
            return f". Did you mean {near[0]}?"
    return ""
