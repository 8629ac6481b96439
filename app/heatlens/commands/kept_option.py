"""The option `--keep-channels`: what of a plate an EXR keeps beside the picture."""

import argparse
from pathlib import Path

from heatlens.errors import InputError
from heatlens.model.plate_options import PlateOptions
from heatlens.plate.kept_channels import check_kept
from heatlens.scene.scene_source import is_scene_source


def add_keep_option(parser: "argparse.ArgumentParser | argparse._ArgumentGroup") -> None:
    """Add it to the options of a command that writes EXR files."""
    parser.add_argument(
        "--keep-channels",
        metavar="NAMES",
        help="other layers and channels of the plate that an EXR keeps as they are: names with "
        "commas, or all",
    )


def kept_names(
    args: argparse.Namespace, source: str, first: Path, options: PlateOptions, proxy: float
) -> tuple[str, ...]:
    """Return the names that were given; `first` is the first file of `source`.

    Raises InputError for a scene, for a smaller picture and for names that the file does not have.
    """
    if not args.keep_channels:
        return ()
    if is_scene_source(source):
        raise InputError(f"{source} is a 3D scene: it has no channels to keep.")
    if proxy != 1.0:
        raise InputError("--keep-channels keeps every pixel as it is: leave --proxy out.")
    wanted = tuple(name.strip() for name in args.keep_channels.split(",") if name.strip())
    check_kept(first, options, wanted)
    return wanted
