"""The option `--keep-channels`: channels of the plate that are copied to an EXR."""

import argparse

from heatlens.base.errors import InputError
from heatlens.commands.options.field_options import add_fields
from heatlens.export.options import ExportOptions
from heatlens.model.shot.plate_options import PlateOptions
from heatlens.plate.kept_channels import check_kept
from heatlens.source.source import Source


def add_keep_option(parser: "argparse.ArgumentParser | argparse._ArgumentGroup") -> None:
    """Add it to the options of a command that writes EXR files."""
    add_fields(parser, ExportOptions, ["keep_channels"])


def kept_names(
    args: argparse.Namespace, source: Source, options: PlateOptions, proxy: float
) -> tuple[str, ...]:
    """Return the given names, checked in the first existing plate.

    Raises InputError for a scene, for a proxy and for names that the file does not have.
    """
    if not args.keep_channels:
        return ()
    if source.first_file is None:
        raise InputError(f"{source.text} is a 3D scene: it has no channels to keep.")
    if proxy != 1.0:
        raise InputError("--keep-channels keeps every pixel as it is: leave --proxy out.")
    wanted = tuple(name.strip() for name in args.keep_channels.split(",") if name.strip())
    check_kept(source.first_file, options, wanted)
    return wanted
