"""The options that say how light becomes a picture for the eye, the same for all that write one.

What nobody says is as the window shows it: the first view of the OpenColorIO config in use.
"""

import argparse
from pathlib import Path

from heatlens.color.color_config import ColorConfig, default_view, load_color_config
from heatlens.color.input_space import input_space_of
from heatlens.color.view_transform import ViewTransform, srgb_transform, view_transform
from heatlens.commands.field_options import add_fields, typed_fields
from heatlens.commands.say import say
from heatlens.errors import InputError
from heatlens.model.look_options import PLAIN_VIEW, LookOptions
from heatlens.plate.channels import Header
from heatlens.plate.header_read import read_color_header


def add_look_options(parser: argparse.ArgumentParser) -> "argparse._ArgumentGroup":
    """Add --ocio, --display, --view, --input-space, --gamma and --exposure; return their group."""
    group = parser.add_argument_group(
        "look",
        "Of pictures and movies; EXR stays scene-linear. Not given, they look as in the window.",
    )
    add_fields(group, LookOptions)
    return group


def look_of(args: argparse.Namespace) -> LookOptions:
    """Return the options of the look as a value."""
    return LookOptions(**typed_fields(args, LookOptions))


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


def transform_of(look: LookOptions, attributes: Header) -> ViewTransform:
    """Return the view transform of the options for light whose header has `attributes`.

    Doubtful choices are reported. Raises InputError for a config that cannot be used, and for names
    that it does not have.
    """
    config = _config(look)
    light = input_space_of(config, attributes, look.input_space or "")
    if light.note:
        say(light.note)
    if config is None:
        return srgb_transform(light.name, light.turned_from)
    display = look.display or config.default_display
    view = look.view or default_view(config, display, attributes)
    return view_transform(config, display, view, light.name, light.turned_from)


def say_seen_through(transform: ViewTransform) -> None:
    """Print the view transform that a picture was made with."""
    say(f"seen through {transform.view} on {transform.display}")


def _config(look: LookOptions) -> ColorConfig | None:
    """Load the config; return None for the plain curve, where it was asked for."""
    if look.view == PLAIN_VIEW and look.ocio is None and look.display is None:
        return None
    return load_color_config(look.ocio)
