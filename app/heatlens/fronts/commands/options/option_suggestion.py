"""Suggest options and commands for a misspelled option."""

import argparse
import difflib
import os
from collections.abc import Sequence
from functools import cache

from heatlens.fronts.commands.command_table import COMMANDS, module_of

_LEAST_SIMILARITY = (
    0.7  # of 1 for the same word; --device is 0.62 like --denoise, --f-stop 0.91 like --fstop
)
_CAMERA_SUFFIXES = (".usd", ".usda", ".usdc", ".json", ".csv")


@cache
def _other_names() -> dict[str, str]:
    """Return the options of heatlens by their names in other programs."""
    from heatlens.core.model.option import OTHER_NAMES  # as slow as all that --version needs

    return {
        f"--{foreign_name}": f"--{option_name}" for foreign_name, option_name in OTHER_NAMES.items()
    }


def is_other_program_option(option: str) -> bool:
    """Return True for an option of other programs that is called something else here.

    "--aperture" is one, although it is also the beginning of --aperture-image.
    """
    name = option.partition("=")[0]
    return not _other_names().get(name, name).startswith(name)


def _other_command_advice(option: str, value: str, program_name: str) -> str:
    """Return advice on the command that takes a wrong option, as the end of a message, or ""."""
    is_file = os.path.splitext(value)[1].lower() in _CAMERA_SUFFIXES
    if option == "--lens-from" or (option == "--camera" and is_file):
        return f". {option} gives the lens of a file to `heatlens shot new` and `heatlens view`."
    if program_name.endswith(" camera") and option in _lens_flags():
        return f". The lens is that of the shot: `heatlens shot new` takes {option}."
    return ""


def _lens_flags() -> set[str]:
    """Return all options of the lens, such as --f-stop."""
    # Imported here, because it is slow and seldom needed.
    from heatlens.fronts.commands.options.lens_options import add_lens_options

    parser = argparse.ArgumentParser(add_help=False)
    add_lens_options(parser)
    return set(parser._option_string_actions)


def option_suggestion(unknown: Sequence[str], parser: argparse.ArgumentParser) -> str:
    """Return a sentence that suggests an option like the wrong one, or the command that has it."""
    known_options = [name for name in parser._option_string_actions if name.startswith("--")]
    for word, next_word in zip(unknown, (*unknown[1:], ""), strict=True):
        option, _, value = word.partition("=")
        if not option.startswith("--"):
            continue
        if advice := _other_command_advice(option, value or next_word, parser.prog):
            return advice
        own_name = _other_names().get(option)
        suggestions = (
            [own_name] if own_name in known_options else _similar_options(option, known_options)
        )
        if suggestions:
            return f". Did you mean {' or '.join(suggestions)}?"
        if commands := _commands_with(option):
            return f". It is an option of {', '.join(f'`heatlens {name}`' for name in commands)}."
    return ""


def _similar_options(option: str, known_options: Sequence[str]) -> list[str]:
    """Return up to two options that extend the wrong one by a word, else the most similar one.

    The leading dashes are not compared, because they would make all short words similar.
    """
    longer_options = [name for name in known_options if name.startswith(f"{option}-")]
    if 0 < len(longer_options) <= 2:
        return sorted(longer_options, reverse=True)
    names = [name.lstrip("-") for name in known_options]
    return [
        f"--{it}"
        for it in difflib.get_close_matches(option.lstrip("-"), names, 1, _LEAST_SIMILARITY)
    ]


def _commands_with(option: str) -> list[str]:
    """Return the names of all commands that have an option."""
    commands = []
    for name in COMMANDS:
        parser = argparse.ArgumentParser(add_help=False)
        module_of(name).add_options(parser)
        commands += [name] if option in parser._option_string_actions else []
    return commands
