"""The options that say how a scene leaves as a plate, and that plate."""

import argparse
import math

from heatlens.commands.say import say
from heatlens.errors import InputError
from heatlens.model.shot import Shot
from heatlens.plate.deep_write import check_deep_fits
from heatlens.plate.plate import Plate
from heatlens.render import FrameRenderer
from heatlens.scene_gpu.scene_renderer import PINHOLE_VIEWS
from heatlens.source.scene_plates import with_overscan

_AUTO = "auto"


def add_pinhole_options(parser: argparse.ArgumentParser) -> None:
    """Add --pinhole, --overscan and --deep."""
    parser.add_argument(
        "--pinhole", action="store_true", help="of a scene: colour and Z without a lens, as a plate"
    )
    parser.add_argument(
        "--overscan",
        type=_overscan,
        metavar="N|auto",
        help="with --pinhole: pixels around the frame, in a data window larger than the display "
        "window, so that they blur in; auto: as many as the lens needs at this frame",
    )
    parser.add_argument(
        "--deep",
        action="store_true",
        help="with --pinhole: a deep EXR, with what lies behind the picture",
    )


def _overscan(text: str) -> int | str:
    if text == _AUTO:
        return text
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of pixels, and not auto.")
    return int(text)


def check_pinhole_options(args: argparse.Namespace, is_exr: bool) -> None:
    """Raise InputError for --overscan and --deep where they mean nothing."""
    names = {"--overscan": args.overscan is not None, "--deep": args.deep}
    wrong = [name for name, is_given in names.items() if is_given]
    if wrong and not args.pinhole:
        raise InputError(
            f"{' and '.join(wrong)}: what a scene has around and behind its picture is used by "
            "itself; these options write it to a plate. Give --pinhole too."
        )
    if wrong and not is_exr:
        raise InputError(f"{' and '.join(wrong)}: {args.output} is not an EXR file.")
    if args.deep and args.compression is not None:
        raise InputError("--deep: a deep file is always compressed as zips; leave --compression.")
    if args.overscan == _AUTO and (args.f_stop is None or args.focus_distance is None):
        raise InputError(
            "--overscan auto: how much blurs in depends on the lens. Give --f-stop and "
            "--focus-distance, or --overscan with a number of pixels."
        )


def pinhole_plate(
    args: argparse.Namespace, renderer: FrameRenderer, shot: Shot, frame: int
) -> Plate:
    """Return the scene's picture as the options wish it, with overscan and what lies behind it."""
    loaded = renderer.look(shot, frame, PINHOLE_VIEWS, is_for_file=args.deep)
    if args.overscan is None and not args.deep:
        return loaded.plate
    margin_px = args.overscan or 0
    if args.overscan == _AUTO:
        overscan = loaded.overscan
        margin_px = 0 if overscan is None else overscan.needed_px(renderer.optics(shot, frame))
        say(f"overscan: {margin_px} pixels on every side, as the lens needs them at frame {frame}")
    width, height = (side + 2 * margin_px for side in loaded.color.size)
    if not args.deep:
        return with_overscan(loaded, margin_px)
    check_deep_fits(args.output, width, height)
    plate = with_overscan(loaded, margin_px, loaded.peeled)
    count = 0 if plate.fragments is None else plate.fragments.count
    say(f"deep: {1 + count / math.prod((width, height)):.2f} surfaces a pixel")
    return plate
