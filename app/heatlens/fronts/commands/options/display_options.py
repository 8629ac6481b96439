"""The options of the view transform, which all commands that write display pictures share.

The default is what the window shows: the first view of the current OpenColorIO config.
"""

import argparse
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.grade import Grade
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.view import NO_GRADE, PLAIN_VIEW, DisplayOptions
from heatlens.deliver.export.job import DisplaySettings
from heatlens.fronts.commands.options.field_options import add_fields, given_fields
from heatlens.fronts.commands.output.say import print_messages
from heatlens.media.color.color_config import ColorConfig, default_view, load_color_config
from heatlens.media.color.grade_file import parse_or_read_grade
from heatlens.media.color.input_space import input_space_of
from heatlens.media.color.view_transform import ViewTransform, srgb_transform, view_transform
from heatlens.media.plate.header.channels import Header
from heatlens.media.plate.parts.header_read import read_color_header
from heatlens.render.source.named import source_of


def add_display_options(parser: argparse.ArgumentParser) -> "argparse._ArgumentGroup":
    """Add the options of `DisplayOptions`; return their group."""
    group = parser.add_argument_group(
        "look",
        "For pictures and movies; EXR stays scene-linear. The default matches the window, but for "
        "pixels that are wider than high: a picture keeps each as one, and `export --desqueeze` "
        "widens them.",
    )
    add_fields(group, DisplayOptions)
    return group


def given_display_options(args: argparse.Namespace) -> DisplayOptions:
    """Return the display options as a value."""
    return DisplayOptions(**given_fields(args, DisplayOptions))


def color_header(path: Path | None, options: PlateOptions) -> Header:
    """Return the header of a plate's colors; it is empty if there is no plate.

    It is also empty if the plate cannot be read, which is reported when the plate is needed.
    """
    if path is None:
        return {}
    try:
        return read_color_header(path, options)
    except InputError:
        return {}


def shot_header(shot: Shot) -> Header:
    """Return the header of a shot's first existing plate."""
    return color_header(source_of(shot).first_file, shot.plate_options)


def display_settings(
    args: argparse.Namespace, header: Header, grade: Grade | None = None
) -> DisplaySettings:
    """Return the display settings for a plate with this header; see `transform_of`."""
    options = given_display_options(args)
    return DisplaySettings(
        transform_of(options, header, grade), options.exposure_stops, options.gamma
    )


def transform_of(
    options: DisplayOptions, attributes: Header, grade: Grade | None = None
) -> ViewTransform:
    """Return the view transform of the options for a plate whose header has `attributes`.

    `grade` is the grade of the shot. Doubtful choices are printed. Raises InputError if the config
    cannot be used, or does not have the given names.
    """
    config = _load_config(options)
    input_space = input_space_of(config, attributes, options.input_space or "")
    if input_space.note:
        print_messages(input_space.note)
    if options.cdl is not None:
        grade = None if options.cdl == NO_GRADE else parse_or_read_grade(options.cdl)
    if config is None:
        if grade is not None:
            print_messages(
                f"the grade (ASC CDL) is not shown: {PLAIN_VIEW!r} is the plain curve alone"
            )
        return srgb_transform(input_space.name, input_space.source_primaries)
    display = options.display or config.default_display
    view = options.view or default_view(config, display, attributes)
    return view_transform(
        config, display, view, input_space.name, input_space.source_primaries, grade
    )


def print_view_transform(transform: ViewTransform) -> None:
    """Print the view transform that a picture was made with."""
    print_messages(f"seen through {transform.view} on {transform.display}")


def _load_config(options: DisplayOptions) -> ColorConfig | None:
    """Load the config; return None if the plain sRGB curve was requested."""
    if options.view == PLAIN_VIEW and options.ocio is None and options.display is None:
        return None
    return load_color_config(options.ocio)
