"""The options that say how light becomes a picture for the eye, the same for all that write one.

What nobody says is as the window shows it: the first view of the OpenColorIO config in use.
"""

import argparse
from pathlib import Path

from heatlens.color.color_config import ColorConfig, default_view, load_color_config
from heatlens.color.input_space import input_space_of
from heatlens.color.view_transform import PLAIN_VIEW, ViewTransform, srgb_transform, view_transform
from heatlens.commands.say import say
from heatlens.commands.value_types import number
from heatlens.errors import InputError
from heatlens.plate.channels import Header
from heatlens.plate.header_read import read_color_header


def add_look_options(parser: argparse.ArgumentParser) -> "argparse._ArgumentGroup":
    """Add --ocio, --display, --view, --input-space, --gamma and --exposure; return their group."""
    group = parser.add_argument_group(
        "look",
        "Of pictures and movies; EXR stays scene-linear. Not given, they look as in the window.",
    )
    group.add_argument(
        "--ocio", metavar="CONFIG", help="OpenColorIO config (default: $OCIO, else a built-in one)"
    )
    group.add_argument("--display", metavar="NAME", help="default: the config's first")
    group.add_argument(
        "--view",
        metavar="NAME",
        help=f"default: the display's first; '{PLAIN_VIEW}' is the plain one",
    )
    group.add_argument(
        "--input-space",
        metavar="NAME",
        help="of the light (default: as the plate's header tells, else linear Rec.709)",
    )
    group.add_argument(
        "--gamma", type=number, default=1.0, metavar="G", help="on top of the view (default 1)"
    )
    group.add_argument(
        "--exposure", type=number, default=0.0, metavar="STOPS", help="brighter by (default 0)"
    )
    return group


def color_header(path: Path | None, color_layer: str | None, eye: str | None = None) -> Header:
    """Return the header of a plate's colours; it is empty where there is no plate.

    Also where the plate cannot be read, which is told when the plate itself is needed.
    """
    if path is None:
        return {}
    try:
        return read_color_header(path, color_layer, eye)
    except InputError:
        return {}


def transform_of(args: argparse.Namespace, attributes: Header) -> ViewTransform:
    """Return the view transform of the options for light whose header has `attributes`.

    Doubtful choices are reported. Raises InputError for a config that cannot be used, and for names
    that it does not have.
    """
    config = _config(args)
    light = input_space_of(config, attributes, args.input_space or "")
    if light.note:
        say(light.note)
    if config is None:
        return srgb_transform(light.name, light.turned_from)
    display = args.display or config.default_display
    view = args.view or default_view(config, display, attributes)
    return view_transform(config, display, view, light.name, light.turned_from)


def say_seen_through(transform: ViewTransform) -> None:
    """Print the view transform that a picture was made with."""
    say(f"seen through {transform.view} on {transform.display}")


def _config(args: argparse.Namespace) -> ColorConfig | None:
    """Load the config; return None for the plain curve, where it was asked for."""
    if args.view == PLAIN_VIEW and args.ocio is None and args.display is None:
        return None
    return load_color_config(args.ocio)
