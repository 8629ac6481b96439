"""The options for other contents of an EXR: a scene as a plate, and channels of the input.

`--pinhole` writes a scene without a lens, as the plate that is made here; `--keep-channels` copies
channels of the plate to an EXR.
"""

import argparse

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.export.options import AUTO_OVERSCAN, ExportOptions, PinholeOptions
from heatlens.deliver.export.pinhole_plate import pinhole_plate
from heatlens.fronts.commands.options.field_options import add_fields
from heatlens.fronts.commands.output.say import print_messages
from heatlens.media.plate.kept_channels import check_kept_channels
from heatlens.media.plate.plate import Plate
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.scene_gpu.overscan import texels_per_pixel
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
        type=_parse_overscan,
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


def _parse_overscan(text: str) -> int | str:
    """Parse --overscan: a number of pixels, or auto. Raises ArgumentTypeError."""
    if text == AUTO_OVERSCAN:
        return text
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} is neither a number of pixels nor auto.")
    return int(text)


def pinhole_options(args: argparse.Namespace) -> PinholeOptions:
    """Return the values of --overscan and --deep."""
    return PinholeOptions(args.overscan, args.deep)


def check_pinhole_options(
    args: argparse.Namespace,
    is_exr: bool,
    has_lens: bool = False,
    default_compression: str | None = None,
) -> None:
    """Raise InputError for --overscan and --deep where they have no effect.

    `has_lens` is True if a shot file defines the lens. A compression given with --deep is an error
    unless it is `default_compression`.
    """
    names = {"--overscan": args.overscan is not None, "--deep": args.deep}
    given_names = [name for name, is_given in names.items() if is_given]
    if given_names and not args.pinhole:
        raise InputError(
            f"{' and '.join(given_names)}: a scene is always rendered with its surroundings; these "
            "options write them to a plate. Give --pinhole too."
        )
    if given_names and not is_exr:
        raise InputError(
            f"{' and '.join(given_names)}: {args.output} is not an EXR file: give a name that ends "
            "in .exr."
        )
    if args.deep and args.compression not in (None, default_compression):
        raise InputError(
            "--deep: a deep file is always compressed as zips: leave --compression out."
        )
    is_known = has_lens or None not in (args.f_stop, args.focus_distance)
    if args.overscan == AUTO_OVERSCAN and not is_known:
        raise InputError(
            "--overscan auto depends on the lens. Give --f-stop and --focus-distance, or "
            "--overscan with a number of pixels."
        )


def render_pinhole_plate(
    args: argparse.Namespace, renderer: FrameRenderer, shot: Shot, frame: int
) -> Plate:
    """Return the scene's picture according to the options; print its overscan and surfaces."""
    plate = pinhole_plate(renderer, shot, frame, pinhole_options(args), args.output)
    if args.overscan == AUTO_OVERSCAN:
        margin_px = -plate.data_window.x0
        print_messages(
            f"overscan: {margin_px} pixels on every side, as the lens needs at frame {frame}"
        )
    if args.deep:
        print_messages(
            f"deep: {_surfaces_a_pixel(plate):.2f} surfaces a pixel{_size_note(renderer, plate)}"
        )
    return plate


def _surfaces_a_pixel(plate: Plate) -> float:
    """Return the mean number of surfaces of a pixel, as the file has them."""
    is_apart = plate.color[..., 3] > 0.0  # a visible surface, which is in no list
    count = 0
    if plate.fragments is not None:
        is_apart &= ~plate.fragments.has_front.reshape(is_apart.shape)
        count = plate.fragments.count
    return (count + int(is_apart.sum())) / is_apart.size


def _size_note(renderer: FrameRenderer, plate: Plate) -> str:
    """Return a note on the size at which the scene itself is blurred, if that is larger."""
    size = plate.display_window.width, plate.display_window.height
    scale = texels_per_pixel(renderer.ctx, size)
    if scale == 1:
        return ""
    larger_size = "x".join(str(scale * side) for side in size)
    return (
        f"; the scene itself is blurred at {scale} times its size: for the same quality, write the "
        f"plate with --size {larger_size} and reduce the picture"
    )


def add_keep_option(parser: "argparse.ArgumentParser | argparse._ArgumentGroup") -> None:
    """Add --keep-channels to the options of a command that writes EXR files."""
    add_fields(parser, ExportOptions, ["keep_channels"])


def parse_kept_channels(
    args: argparse.Namespace, source: Source, options: PlateOptions, proxy: float
) -> tuple[str, ...]:
    """Return the channel names of --keep-channels, after finding them in the first existing plate.

    Raises InputError for a scene, for a proxy and for names that the file does not have.
    """
    if not args.keep_channels:
        return ()
    if source.first_file is None:
        raise InputError(f"{source.text} is a 3D scene: it has no channels to keep.")
    if proxy != 1.0:
        raise InputError("--keep-channels keeps every pixel as it is: leave --proxy out.")
    channel_names = tuple(name.strip() for name in args.keep_channels.split(",") if name.strip())
    check_kept_channels(source.first_file, options, channel_names)
    return channel_names
