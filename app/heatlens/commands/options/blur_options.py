"""The options for computing the blur, which all commands that blur share."""

import argparse
from dataclasses import replace

from heatlens.commands.options.field_options import add_fields, typed_fields
from heatlens.model.settings import DefocusSettings

_USUAL = DefocusSettings()


def add_blur_options(parser: argparse.ArgumentParser) -> None:
    """Add the group `blur` to `parser`: an option for each field of DefocusSettings."""
    group = parser.add_argument_group("blur", "How the blur is computed, not how large it is.")
    add_fields(group, DefocusSettings)


def settings_of(
    args: argparse.Namespace, unless_given: DefocusSettings = _USUAL
) -> DefocusSettings:
    """Return the blur settings of the options; missing ones are taken from `unless_given`.

    Raises InputError for impossible numbers.
    """
    return replace(unless_given, **typed_fields(args, DefocusSettings))
