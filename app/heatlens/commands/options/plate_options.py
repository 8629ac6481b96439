"""The options for reading a plate, which all commands that read one share."""

import argparse

from heatlens.commands.options.field_options import add_fields, typed_fields
from heatlens.commands.options.lens_options import sensor_width_of
from heatlens.model.plate_options import PlateOptions


def add_plate_options(parser: argparse.ArgumentParser) -> None:
    """Add the group `how to read the plate` to `parser`: an option for each field that has one."""
    add_fields(parser.add_argument_group("how to read the plate"), PlateOptions)


def plate_options(args: argparse.Namespace) -> PlateOptions:
    """Return the plate options, with lens and film back if the command has options for them.

    Raises HeatlensError for an unknown unit or film back.
    """
    return PlateOptions(
        focal_length_mm=getattr(args, "focal_length", None),
        sensor_width_mm=sensor_width_of(args),
        **typed_fields(args, PlateOptions),
    )
