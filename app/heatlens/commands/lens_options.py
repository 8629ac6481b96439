"""The lens on the command line: what is given wins, then the plate's header; each is said aloud."""

import argparse
import math
from dataclasses import dataclass

from heatlens.errors import InputError
from heatlens.image.focus_pick import depth_at_m, no_distances
from heatlens.image.plate import Plate
from heatlens.model.filmback import filmback_named
from heatlens.model.lens import Lens
from heatlens.model.units import format_distance, parse_distance_m

_FULL_FRAME_WIDTH_MM = 36.0
_LENS_VALUES = ("focal_length", "sensor_width", "filmback", "f_stop", "focus_distance")


@dataclass(frozen=True)
class _Named:
    value: float
    source: str


def add_lens_options(parser: argparse.ArgumentParser) -> None:
    """--focal-length, --sensor-width or --filmback, --f-stop, focus, --squeeze."""
    group = parser.add_argument_group(
        "lens", "Values not given are taken from the plate's header where it has them."
    )
    group.add_argument("--focal-length", type=float, metavar="MM", help="in millimetres")
    back = group.add_mutually_exclusive_group()
    back.add_argument(
        "--sensor-width", type=float, metavar="MM", help="width of the film back in millimetres"
    )
    back.add_argument("--filmback", metavar="NAME", help='a film back by name, as "Super 35"')
    group.add_argument("--f-stop", type=float, metavar="N", help="2 for f/2; smaller blurs more")
    focus = group.add_mutually_exclusive_group()
    focus.add_argument(
        "--focus-distance", metavar="DISTANCE", help="metres, or with a unit: 190cm, 6'3\", inf"
    )
    focus.add_argument(
        "--focus-at", metavar="X,Y", help="focus on what is seen at this pixel of the picture"
    )
    group.add_argument(
        "--squeeze",
        type=float,
        default=1.0,
        metavar="S",
        help="anamorphic lens, 1 to 2: discs become S times as tall as wide (default 1)",
    )


def lens_of(args: argparse.Namespace, plate: Plate) -> tuple[Lens, list[str]]:
    """The lens that the options and the plate's header describe, and a sentence on each value."""
    if plate.coc_px is not None:
        return _lens_of_coc(args, plate)
    camera = plate.camera
    focal = _from_header(args.focal_length, plate, "focal_length_mm", "--focal-length")
    f_stop = _from_header(args.f_stop, plate, "f_stop", "--f-stop")
    if args.filmback is not None:
        sensor = _Named(filmback_named(args.filmback).width_mm, f"film back {args.filmback}")
    elif args.sensor_width is None and camera.sensor_width_mm is None:
        sensor = _Named(_FULL_FRAME_WIDTH_MM, "assumed full frame; --sensor-width changes it")
    else:
        sensor = _from_header(args.sensor_width, plate, "sensor_width_mm", "--sensor-width")
    focus = _focus(args, plate)
    lens = Lens(
        focal_length_mm=focal.value,
        f_stop=f_stop.value,
        focus_distance_m=focus.value,
        sensor_width_mm=sensor.value,
        squeeze=args.squeeze,
    )
    said = [
        f"focal length {focal.value:g} mm ({focal.source})",
        f"sensor width {sensor.value:g} mm ({sensor.source})",
        f"f/{f_stop.value:g} ({f_stop.source})",
        f"focus {format_distance(focus.value)} ({focus.source})",
    ]
    return lens, said


def _lens_of_coc(args: argparse.Namespace, plate: Plate) -> tuple[Lens, list[str]]:
    """A lens of which only the squeeze counts: the plate brings its circle of confusion."""
    if args.focus_at is not None:
        raise no_distances(plate)
    said = ["none needed, the plate brings its circle of confusion"]
    given = [name for name in _LENS_VALUES if getattr(args, name) is not None]
    said += [f"--{name.replace('_', '-')} is not used" for name in given]
    return Lens(50.0, 2.8, math.inf, _FULL_FRAME_WIDTH_MM, args.squeeze), said


def _from_header(given: float | None, plate: Plate, field: str, option: str) -> _Named:
    if given is not None:
        return _Named(given, option)
    value = getattr(plate.camera, field)
    if value is None:
        name = field.removesuffix("_mm").replace("_", " ")
        raise InputError(f"{plate.path}: the header tells no {name}; give it with {option}.")
    return _Named(value, f"header, {plate.camera.sources.get(field, 'camera')}")


def _focus(args: argparse.Namespace, plate: Plate) -> _Named:
    if args.focus_at is not None:
        x, y = _pixel(args.focus_at)
        return _Named(depth_at_m(plate, x, y), f"--focus-at {x},{y}")
    if args.focus_distance is not None:
        return _Named(parse_distance_m(args.focus_distance), "--focus-distance")
    if plate.camera.focus_distance_m is None:
        raise InputError(
            f"{plate.path}: the header tells no focus distance; "
            "give it with --focus-distance or --focus-at."
        )
    return _from_header(None, plate, "focus_distance_m", "--focus-distance")


def _pixel(text: str) -> tuple[int, int]:
    try:
        x, y = (int(part) for part in text.split(","))
    except ValueError:
        raise InputError(
            f"--focus-at takes a pixel as X,Y, for instance 960,540; got {text!r}."
        ) from None
    return x, y
