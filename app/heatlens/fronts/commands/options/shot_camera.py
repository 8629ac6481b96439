"""The option --camera: a camera file supplies the lens options that are not given."""

import argparse
from collections.abc import Collection

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.units import format_distance, parse_scene_unit_m
from heatlens.fronts.commands.options.field_options import attributes_of
from heatlens.fronts.commands.output.say import say
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
    **{name: attributes_of(Lens, [name]) for name in (*OPENING_TRACKS, "aperture_image")},
}


def add_camera_option(parser: argparse.ArgumentParser, wins: str = "options and --key") -> None:
    """Add --camera; `wins` names what overrides its values."""
    parser.add_argument(
        "--camera",
        "--lens-from",
        dest="camera",
        metavar="CAMERA",
        help="lens, keys, frames and rate of a camera: cam.usda, shot.usda:/world/cam, a .json "
        "or .csv of `heatlens camera`, the .csv of a shoot (ARRI, RED, Sony; take.csv@1001 "
        "puts its first row at frame 1001), or the headers of 'plate.####.exr'; values "
        f"given with {wins} take precedence",
    )
    parser.add_argument(
        "--table-unit",
        metavar="focus=UNIT",
        help="unit of the focus in the table of a shoot, where its numbers have none: focus=mm, "
        "cm, ft, in (default: that of the column's name, else metres)",
    )


def camera_of(args: argparse.Namespace) -> CameraSamples | None:
    """Return the camera of the options, if any."""
    if args.camera is not None:
        return read_camera(args.camera, focus_unit_m=_table_unit_m(args.table_unit))
    if args.table_unit is not None:
        raise InputError("--table-unit is for the table of a shoot, which --lens-from names.")
    return None


def _table_unit_m(text: str | None) -> float | None:
    """Return the metres in the unit that --table-unit gives the focus; None without it."""
    if text is None:
        return None
    name, is_told, unit = text.partition("=")
    if name.strip() != "focus" or not is_told:
        raise InputError(f"--table-unit takes focus=UNIT, as focus=mm, got {text!r}.")
    return parse_scene_unit_m(unit.strip())


def checked_camera_of(args: argparse.Namespace, kept: Collection[str]) -> CameraSamples | None:
    """Return the camera of the options, after checking that its lens is possible for a shot.

    The fields in `kept` are not taken from the camera, and not checked.
    """
    camera = camera_of(args)
    if camera is not None:
        lens_tracks(camera, kept)
        say(*camera.notes)
    return camera


def decided_otherwise(args: argparse.Namespace, keyed: Collection[LensParameter]) -> frozenset[str]:
    """Return the fields of the lens that are set by options or keys."""
    given = {
        field
        for field, options in _OPTIONS.items()
        if any(getattr(args, option) is not None for option in options)
    }
    return frozenset(given.union(map(str, keyed)))


def with_camera_values(
    args: argparse.Namespace, camera: CameraSamples, kept: Collection[str]
) -> argparse.Namespace:
    """Return the options, with the camera's first values for missing ones, and their origin."""
    filled = argparse.Namespace(**vars(args))
    filled.origins = dict.fromkeys(first_values(camera, kept), args.camera)
    for field, first in first_values(camera, kept).items():
        # The focus is text on the command line, because it can have a unit.
        value = repr(first) if field == "focus_distance_m" else first
        setattr(filled, _OPTIONS[field][0], value)
    return filled


def said_of(camera: CameraSamples, shot: Shot, text: str, kept: Collection[str]) -> str:
    """Return a sentence on the camera that was used, its file, and the values taken from it."""
    frames = f", frames {camera.frame_range}" if camera.frame_range else ""
    tracks = lens_tracks(camera, kept)
    taken = [
        f"{LENS_TRACKS[name]} {_span(name, min(track), max(track))}{_keys(shot, name)}"
        for name, track in tracks.items()
        if name not in camera.opening or name in camera.shaped
    ]
    if camera.lens_model is not None and "model" not in kept:
        taken.append(f"discs of a {camera.lens_model.facts.words}")
    return f"lens of camera {camera.name} in {text}{frames}: {', '.join(taken) or 'nothing'}."


def _span(name: str, least: float, most: float) -> str:
    """Format a value with its unit, or the range in which it moves."""
    if name == "focus_distance_m":
        ends = format_distance(least), format_distance(most)
    else:
        unit = " mm" if name.endswith("_mm") else ""
        ends = f"{least:.4g}{unit}", f"{most:.4g}{unit}"
    return ends[0] if least == most else f"{ends[0]} to {ends[1]}"


def _keys(shot: Shot, name: str) -> str:
    if name not in list(LensParameter):
        return ""
    count = len(shot.curves.of(LensParameter(name)).keys)
    return f" ({count} keys)" if count else ""
