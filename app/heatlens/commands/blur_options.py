"""The options that say how the blur is computed, the same for every command that blurs."""

import argparse
from dataclasses import replace

from heatlens.commands.field_options import add_fields, typed_fields
from heatlens.model.settings import DefocusSettings

_USUAL = DefocusSettings()


def add_blur_options(parser: argparse.ArgumentParser) -> None:
    """Add the group `blur` to `parser`: an option for each field of DefocusSettings."""
    group = parser.add_argument_group("blur", "How it is computed, never how much of it there is.")
    add_fields(group, DefocusSettings)


def settings_of(
    args: argparse.Namespace, unless_given: DefocusSettings = _USUAL
) -> DefocusSettings:
    """Return the blur options as a value; what is not given is as in `unless_given`.

    Raises InputError for numbers that no blur has.
    """
    return replace(unless_given, **typed_fields(args, DefocusSettings))
