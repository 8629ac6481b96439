"""The lens on the command line: what is given wins, then the plate's header; each is said aloud."""

import argparse
from collections.abc import Mapping

from heatlens.commands.value_types import f_number, millimetres, number, with_point
from heatlens.errors import InputError
from heatlens.model.filmback import filmback_named
from heatlens.model.lens import Lens
from heatlens.model.units import format_distance, parse_distance_m
from heatlens.plate.focus_pick import depth_at_m, no_distances
from heatlens.plate.header_lens import LensNotToldError, plate_lens
from heatlens.plate.plate import Plate

_TOLD = {
    "focal_length_mm": "--focal-length",
    "sensor_width_mm": "--sensor-width",
    "f_stop": "--f-stop",
    "focus_distance_m": "--focus-distance",
}
_GIVEN_WITH = {**_TOLD, "focus_distance_m": "--focus-distance or --focus-at"}
_LENS_VALUES = ("focal_length", "sensor_width", "filmback", "f_stop", "focus_distance")


def add_lens_options(parser: argparse.ArgumentParser, can_pick: bool = True) -> None:
    """--focal-length, --sensor-width or --filmback, --f-stop, focus, --squeeze.

    `can_pick` False: without --focus-at, for what has no picture yet to pick from.
    """
    group = parser.add_argument_group(
        "lens",
        "Values not given are taken from the plate's header or the scene's camera, where these "
        "have them.",
    )
    group.add_argument("--focal-length", type=millimetres, metavar="MM", help="in millimetres")
    back = group.add_mutually_exclusive_group()
    back.add_argument(
        "--sensor-width", type=millimetres, metavar="MM", help="of the film back, in millimetres"
    )
    back.add_argument("--filmback", metavar="NAME", help='a film back by name, as "Super 35"')
    group.add_argument("--f-stop", type=f_number, metavar="N", help="2 or f/2; smaller blurs more")
    focus = group.add_mutually_exclusive_group()
    focus.add_argument(
        "--focus-distance", metavar="DISTANCE", help="metres, or with a unit: 190cm, 6'3\", inf"
    )
    if can_pick:
        focus.add_argument(
            "--focus-at", metavar="X,Y", help="focus on what is seen at this pixel of the picture"
        )
    group.add_argument(
        "--squeeze",
        type=number,
        metavar="S",
        help="anamorphic lens, 1 to 2: discs become S times as tall as wide (default 1)",
    )


def sensor_width_of(args: argparse.Namespace) -> float | None:
    """Millimetres, as --sensor-width or --filmback say; None where neither is given.

    Raises InputError for a film back that is none.
    """
    name: str | None = getattr(args, "filmback", None)
    width_mm: float | None = getattr(args, "sensor_width", None)
    return width_mm if name is None else filmback_named(name).width_mm


def given_lens(args: argparse.Namespace) -> dict[str, float]:
    """Fields of Lens that the options give, all but what --focus-at finds.

    Raises InputError for what is no distance and no film back.
    """
    typed = args.focus_distance
    focus = None if typed is None else parse_distance_m(with_point(typed))
    values = {
        "focal_length_mm": args.focal_length,
        "sensor_width_mm": sensor_width_of(args),
        "f_stop": args.f_stop,
        "focus_distance_m": focus,
        "squeeze": args.squeeze,
    }
    return {name: value for name, value in values.items() if value is not None}


def lens_of(args: argparse.Namespace, plate: Plate) -> tuple[Lens, str]:
    """The lens that the options and the plate's header describe, and a sentence on each value."""
    values, sources = given_lens(args), sources_of(args)
    if plate.coc_px is not None:
        return _lens_of_coc(args, plate, values.get("squeeze", 1.0))
    if args.focus_at is not None:
        values["focus_distance_m"] = depth_at_m(plate, *pixel_of(args.focus_at))
    try:
        found = plate_lens(plate, values)
    except LensNotToldError as error:
        raise InputError(error.told(_GIVEN_WITH)) from None
    changed = {"assumed full frame": f"assumed full frame; {_TOLD['sensor_width_mm']} changes it"}
    told = {field: changed.get(source, source) for field, source in found.sources.items()}
    return found.lens, f"lens: {lens_words(found.lens, {**told, **sources})}"


def sources_of(args: argparse.Namespace) -> dict[str, str]:
    """By field of Lens, the option that gives it."""
    back = f"film back {args.filmback}" if args.filmback is not None else "--sensor-width"
    focus = "--focus-distance" if args.focus_at is None else f"--focus-at {args.focus_at}"
    typed = {**_TOLD, "sensor_width_mm": back, "focus_distance_m": focus}
    given = given_lens(args)
    return {
        field: option
        for field, option in typed.items()
        if field in given or (field == "focus_distance_m" and args.focus_at is not None)
    }


def lens_words(lens: Lens, sources: Mapping[str, str]) -> str:
    """Each value of a lens, and where it is from."""
    values = {
        "focal_length_mm": f"focal length {lens.focal_length_mm:g} mm",
        "sensor_width_mm": f"sensor width {lens.sensor_width_mm:g} mm",
        "f_stop": f"f/{lens.f_stop:g}",
        "focus_distance_m": f"focus {format_distance(lens.focus_distance_m)}",
    }
    return ", ".join(f"{text} ({sources[field]})" for field, text in values.items())


def _lens_of_coc(args: argparse.Namespace, plate: Plate, squeeze: float) -> tuple[Lens, str]:
    """A lens of which only the squeeze counts: the plate brings its circle of confusion."""
    if args.focus_at is not None:
        raise no_distances(plate)
    said = ["lens: none needed, the plate brings its circle of confusion"]
    given = [name for name in _LENS_VALUES if getattr(args, name) is not None]
    said += [f"--{name.replace('_', '-')} is not used" for name in given]
    return plate_lens(plate, {"squeeze": squeeze}).lens, ", ".join(said)


def pixel_of(text: str) -> tuple[int, int]:
    """X,Y as --focus-at takes it; raises InputError for what is no pixel."""
    try:
        x, y = (int(part) for part in text.split(","))
    except ValueError:
        raise InputError(
            f"--focus-at takes a pixel as X,Y, for instance 960,540; got {text!r}."
        ) from None
    return x, y
