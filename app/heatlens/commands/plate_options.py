"""The options that say how to read a plate, the same for every command that reads one."""

import argparse
import os

from heatlens.commands.lens_options import sensor_width_of
from heatlens.commands.value_types import finite
from heatlens.model.plate_options import DepthConvention, DepthKind, PictureCurve, PlateOptions
from heatlens.model.units import parse_scene_unit_m


def add_plate_options(parser: argparse.ArgumentParser) -> None:
    """Add the group `how to read the plate` to `parser`."""
    group = parser.add_argument_group("how to read the plate")
    group.add_argument(
        "--depth",
        metavar="FILE",
        help="the depth, where it lies in a file of its own: EXR, PNG, TIFF, PFM, NPY; of a "
        "sequence its pattern, depth.####.exr",
    )
    group.add_argument(
        "--behind",
        metavar="FILE",
        action="append",
        help="a picture with depth of what lies behind, rendered by the same camera: a clean "
        "plate, a background; of a sequence its pattern. May be given several times, in any order. "
        "Parts and layers of the plate called behind, behind.1, ... are taken by themselves",
    )
    group.add_argument(
        "--depth-channel",
        metavar="NAME",
        help="channel that holds the depth, as `heatlens info` lists it (default: found by name)",
    )
    group.add_argument(
        "--color-layer",
        metavar="NAME",
        help="layer that holds R, G, B; '' is the one without a name (default: found by name)",
    )
    group.add_argument(
        "--eye",
        metavar="NAME",
        help="view of a stereo file: left, right, or as `heatlens info` lists it (default: the "
        "first)",
    )
    group.add_argument(
        "--depth-convention",
        choices=[str(convention) for convention in DepthConvention],
        help=f"what the depth values are: {_conventions()} (default: auto)",
    )
    group.add_argument(
        "--depth-kind",
        choices=[str(kind) for kind in DepthKind if kind is not DepthKind.AUTO],
        help="planar: measured along the optical axis, a wall seen straight on has one depth "
        "(default, but for channels named as Mitsuba's distances along the ray); radial: along "
        "each ray, which needs focal length and sensor width",
    )
    group.add_argument(
        "--scene-unit",
        metavar="UNIT",
        help="unit of the depth values: m, cm, mm, ft, in, or a number of metres (default: m)",
    )
    group.add_argument(
        "--strict",
        action="store_true",
        help="refuse a depth that can be read in two ways, and a focus, lens and depth that can "
        "hardly belong together, instead of saying so and going on",
    )
    group.add_argument(
        "--near", metavar="METRES", type=finite, help="near end of a normalized depth or disparity"
    )
    group.add_argument("--far", metavar="METRES", type=finite, help="its far end")
    group.add_argument(
        "--picture-curve",
        choices=[str(curve) for curve in PictureCurve if curve is not PictureCurve.AUTO],
        help="of PNG, JPEG and TIFF as colour: whole numbers are sRGB, floating point is linear "
        "light, unless told otherwise",
    )


def _conventions() -> str:
    """Return each convention with its meaning, and whether it takes --near and --far."""
    told = []
    for convention in DepthConvention:
        ends = ", with --near and --far" if convention.facts.needs_ends else ""
        told.append(f"{convention} ({convention.facts.meaning}){ends}")
    return "; ".join(told)


def plate_options(args: argparse.Namespace) -> PlateOptions:
    """What `args` say; the lens and the film back count where the command has options for them.

    Raises HeatlensError for a unit or a film back that is none.
    """
    return PlateOptions(
        depth_channel=args.depth_channel,
        color_layer=args.color_layer,
        depth_convention=args.depth_convention or DepthConvention.AUTO,
        depth_kind=args.depth_kind or DepthKind.AUTO,
        scene_unit_m=parse_scene_unit_m(args.scene_unit or "m"),
        near_m=args.near,
        far_m=args.far,
        focal_length_mm=getattr(args, "focal_length", None),
        sensor_width_mm=sensor_width_of(args),
        depth_source=None if args.depth is None else os.path.expanduser(args.depth),
        behind=tuple(os.path.expanduser(text) for text in args.behind or ()),
        picture_curve=args.picture_curve or PictureCurve.AUTO,
        eye=args.eye,
        strict=args.strict,
    )
