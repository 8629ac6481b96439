"""The option --camera: a camera file supplies the lens options that are not given."""

import argparse
from collections.abc import Collection

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.units import format_distance, parse_scene_unit_m
from heatlens.fronts.commands.options.field_options import attribute_names
from heatlens.fronts.commands.output.say import print_messages
from heatlens.media.camera.camera_file import read_camera
from heatlens.media.camera.into_shot import first_values, lens_tracks
from heatlens.media.camera.samples import LENS_TRACKS, OPENING_TRACKS, CameraSamples

# Field of Lens -> the options that set it. The camera's value is used for the first one.
_OPTIONS = {
    "focal_length_mm": ("focal_length",),
    "f_stop": ("f_stop",),
    "focus_distance_m": ("focus_distance", "focus_at"),
    "sensor_width_mm": ("sensor_width", "filmback"),
    "squeeze": ("squeeze",),
    "model": ("lens_model",),
    **{name: attribute_names(Lens, [name]) for name in (*OPENING_TRACKS, "aperture_image")},
}


def add_camera_option(
    parser: argparse.ArgumentParser, stronger_options: str = "options and --key"
) -> None:
    """Add --camera and --table-unit; the help says that `stronger_options` override the camera."""
    parser.add_argument(
        "--camera",
        "--lens-from",
        dest="camera",
        metavar="CAMERA",
        help="lens, keys, frames and rate of a camera: cam.usda, shot.usda:/world/cam, a .json "
        "or .csv of `heatlens camera`, the table of a shoot (take.csv@1001: its first row is frame "
        f"1001), or the headers of 'plate.####.exr'; {stronger_options} take precedence",
    )
    parser.add_argument(
        "--table-unit",
        metavar="focus=UNIT",
        help="unit of the focus in the table of a shoot, where its numbers have none: focus=mm, "
        "cm, ft, in (default: that of the column's name, else metres)",
    )


def read_given_camera(args: argparse.Namespace) -> CameraSamples | None:
    """Return the camera of the options, if any. Raises InputError."""
    if args.camera is not None:
        return read_camera(args.camera, focus_unit_m=_table_unit_m(args.table_unit))
    if args.table_unit is not None:
        raise InputError("--table-unit is for the table of a shoot, which --lens-from names.")
    return None


def _table_unit_m(text: str | None) -> float | None:
    """Return the meters in the unit that --table-unit gives the focus; None without it."""
    if text is None:
        return None
    name, separator, unit = text.partition("=")
    if name.strip() != "focus" or not separator:
        raise InputError(f"--table-unit takes focus=UNIT, as focus=mm, got {text!r}.")
    return parse_scene_unit_m(unit.strip())


def read_checked_camera(
    args: argparse.Namespace, excluded: Collection[str]
) -> CameraSamples | None:
    """Return the camera of the options, after checking that its lens is possible for a shot.

    The fields in `excluded` are not taken from the camera, and not checked. Prints messages.
    """
    camera = read_given_camera(args)
    if camera is not None:
        lens_tracks(camera, excluded)
        print_messages(*camera.notes)
    return camera


def fields_not_from_camera(
    args: argparse.Namespace, keyed_parameters: Collection[LensParameter]
) -> frozenset[str]:
    """Return the fields of the lens that options or keys set, instead of the camera."""
    given_fields = {
        field
        for field, options in _OPTIONS.items()
        if any(getattr(args, option) is not None for option in options)
    }
    return frozenset(given_fields.union(map(str, keyed_parameters)))


def fill_from_camera(
    args: argparse.Namespace, camera: CameraSamples, excluded: Collection[str]
) -> argparse.Namespace:
    """Return the options, with the camera's first values for those that are missing.

    The fields in `excluded` are not filled; `origins` records the camera for each filled field.
    """
    filled = argparse.Namespace(**vars(args))
    filled.origins = dict.fromkeys(first_values(camera, excluded), args.camera)
    for field, first_value in first_values(camera, excluded).items():
        # The focus is text on the command line, because it can have a unit.
        value = repr(first_value) if field == "focus_distance_m" else first_value
        setattr(filled, _OPTIONS[field][0], value)
    return filled


def camera_message(camera: CameraSamples, shot: Shot, text: str, excluded: Collection[str]) -> str:
    """Return a message on the camera that was used, its file, and the values taken from it."""
    frames = f", frames {camera.frame_range}" if camera.frame_range else ""
    tracks = lens_tracks(camera, excluded)
    value_texts = [
        f"{LENS_TRACKS[name]} "
        f"{_range_text(name, min(track), max(track))}{_key_count_text(shot, name)}"
        for name, track in tracks.items()
        if name not in camera.opening or name in camera.shaped_fields
    ]
    if camera.lens_model is not None and "model" not in excluded:
        value_texts.append(f"discs of a {camera.lens_model.facts.words}")
    return f"lens of camera {camera.name} in {text}{frames}: {', '.join(value_texts) or 'nothing'}."


def _range_text(name: str, least: float, most: float) -> str:
    """Format a value with its unit, or the range in which it moves."""
    if name == "focus_distance_m":
        ends = format_distance(least), format_distance(most)
    else:
        unit = " mm" if name.endswith("_mm") else ""
        ends = f"{least:.4g}{unit}", f"{most:.4g}{unit}"
    return ends[0] if least == most else f"{ends[0]} to {ends[1]}"


def _key_count_text(shot: Shot, name: str) -> str:
    """Return the number of keys of a lens value in brackets, or ""."""
    if name not in list(LensParameter):
        return ""
    count = len(shot.curves.of(LensParameter(name)).keys)
    return f" ({count} keys)" if count else ""
