"""The options for what else an EXR holds: a scene as a plate, and channels of the input.

`--pinhole` writes a scene without a lens, as the plate that is made here; `--keep-channels` copies
channels of the plate to an EXR.
"""

import argparse

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.export.options import ExportOptions
from heatlens.deliver.export.pinhole_plate import AUTO, PinholeOptions, pinhole_plate
from heatlens.fronts.commands.options.field_options import add_fields
from heatlens.fronts.commands.output.say import say
from heatlens.media.plate.kept_channels import check_kept
from heatlens.media.plate.plate import Plate
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.scene_gpu.overscan import fineness
from heatlens.render.source.source import Source


def add_pinhole_options(parser: argparse.ArgumentParser) -> None:
    """Add --pinhole, --overscan and --deep."""
    parser.add_argument(
        "--pinhole",
        action="store_true",
        help="write a scene's colour and Z without a lens, as a plate",
    )
    parser.add_argument(
        "--overscan",
        type=_overscan,
        metavar="N|auto",
        help="with --pinhole: extra pixels around the frame, so that surroundings can blur "
        "into it (the data window is larger than the display window); auto: as many as the lens "
        "needs at each frame",
    )
    parser.add_argument(
        "--deep",
        action="store_true",
        help="with --pinhole: a deep EXR, with the surfaces behind the picture",
    )


def _overscan(text: str) -> int | str:
    if text == AUTO:
        return text
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} is neither a number of pixels nor auto.")
    return int(text)


def pinhole_options(args: argparse.Namespace) -> PinholeOptions:
    return PinholeOptions(args.overscan, args.deep)


def check_pinhole_options(
    args: argparse.Namespace, is_exr: bool, has_lens: bool = False, usual: str | None = None
) -> None:
    """Raise InputError for --overscan and --deep where they have no effect.

    `has_lens` is True if a shot file defines the lens; `usual` is the default compression.
    """
    names = {"--overscan": args.overscan is not None, "--deep": args.deep}
    wrong = [name for name, is_given in names.items() if is_given]
    if wrong and not args.pinhole:
        raise InputError(
            f"{' and '.join(wrong)}: a scene is always rendered with its surroundings; these "
            "options write them to a plate. Give --pinhole too."
        )
    if wrong and not is_exr:
        raise InputError(f"{' and '.join(wrong)}: {args.output} is not an EXR file.")
    if args.deep and args.compression not in (None, usual):
        raise InputError(
            "--deep: a deep file is always compressed as zips: leave --compression out."
        )
    is_known = has_lens or None not in (args.f_stop, args.focus_distance)
    if args.overscan == AUTO and not is_known:
        raise InputError(
            "--overscan auto depends on the lens. Give --f-stop and --focus-distance, or "
            "--overscan with a number of pixels."
        )


def rendered_plate(
    args: argparse.Namespace, renderer: FrameRenderer, shot: Shot, frame: int
) -> Plate:
    """Return the scene's picture according to the options; print its overscan and surfaces."""
    plate = pinhole_plate(renderer, shot, frame, pinhole_options(args), args.output)
    if args.overscan == AUTO:
        margin_px = -plate.data_window.x0
        say(f"overscan: {margin_px} pixels on every side, as the lens needs at frame {frame}")
    if args.deep:
        count = 0 if plate.fragments is None else plate.fragments.count
        pixels = plate.data_window.width * plate.data_window.height
        say(f"deep: {1 + count / pixels:.2f} surfaces a pixel{_smaller(renderer, plate)}")
    return plate


def _smaller(renderer: FrameRenderer, plate: Plate) -> str:
    """Return a note on the size at which the scene itself is blurred, if that is larger."""
    size = plate.display_window.width, plate.display_window.height
    fine = fineness(renderer.ctx, size)
    if fine == 1:
        return ""
    larger = "x".join(str(fine * side) for side in size)
    return (
        f"; the scene itself is blurred at {fine} times its size: for the same quality, write the "
        f"plate with --size {larger} and reduce the picture"
    )


def add_keep_option(parser: "argparse.ArgumentParser | argparse._ArgumentGroup") -> None:
    """Add it to the options of a command that writes EXR files."""
    add_fields(parser, ExportOptions, ["keep_channels"])


def kept_names(
    args: argparse.Namespace, source: Source, options: PlateOptions, proxy: float
) -> tuple[str, ...]:
    """Return the given names, checked in the first existing plate.

    Raises InputError for a scene, for a proxy and for names that the file does not have.
    """
    if not args.keep_channels:
        return ()
    if source.first_file is None:
        raise InputError(f"{source.text} is a 3D scene: it has no channels to keep.")
    if proxy != 1.0:
        raise InputError("--keep-channels keeps every pixel as it is: leave --proxy out.")
    wanted = tuple(name.strip() for name in args.keep_channels.split(",") if name.strip())
    check_kept(source.first_file, options, wanted)
    return wanted
