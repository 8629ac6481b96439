"""`heatlens render`: render one plate or scene through a lens, to an EXR or a PNG."""

import argparse
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.export.job import DisplaySettings
from heatlens.fronts.commands.options.device_option import add_device_option, use_device
from heatlens.fronts.commands.options.display_options import (
    add_display_options,
    color_header,
    display_settings,
    print_view_transform,
)
from heatlens.fronts.commands.options.field_options import add_blur_options, settings_of
from heatlens.fronts.commands.options.frame_command import add_frame_options, choose_one_frame
from heatlens.fronts.commands.options.given_options import changed_options, refuse_unused_options
from heatlens.fronts.commands.options.lens_options import plate_options
from heatlens.fronts.commands.options.pinhole_output import (
    add_keep_option,
    add_pinhole_options,
    check_pinhole_options,
    parse_kept_channels,
    render_pinhole_plate,
)
from heatlens.fronts.commands.output.picture_progress import picture_progress
from heatlens.fronts.commands.output.pipes import DASH, file_for_output, stdin_as_file
from heatlens.fronts.commands.output.say import print_messages, print_result
from heatlens.fronts.commands.sources.source_commands import commands_for
from heatlens.media.color.color_config import load_color_config
from heatlens.media.files.atomic_file import check_space, make_folder
from heatlens.media.files.marks import blurred_mark
from heatlens.media.files.picture_formats import words_written
from heatlens.media.plate.deep.deep_write import write_deep
from heatlens.media.plate.exr.exr_write import COMPRESSIONS
from heatlens.media.plate.kept_channels import read_kept_channels
from heatlens.media.plate.picture.display import encode_srgb
from heatlens.media.plate.picture.picture_write import (
    Encode,
    check_output,
    lens_header,
    write_picture,
)
from heatlens.media.plate.plate import Plate
from heatlens.media.scene.scene_read import files_of_scene
from heatlens.render.display.display_values import DisplayValues
from heatlens.render.frame_renderer import FrameRenderer, headless_renderer, run_all_steps
from heatlens.render.gpu.textures import FloatArray, download
from heatlens.render.source.named import single_source

_COMPRESSED_SHARE = 0.1  # size of a well compressed picture, as a part of its uncompressed size
DESCRIPTION = """\
Puts a lens in front of a pinhole plate (EXR with colour and depth) or a 3D scene (glTF, OBJ, PLY,
USD) and writes the picture: EXR scene-linear with the lens in its header, or PNG, JPEG or TIFF for
viewing.
"""
EPILOG = """\
examples:
  heatlens render plate.exr -o out.exr --f-stop 2 --focus-distance 2.24 \\
      --focal-length 50 --sensor-width 36
  heatlens render plate.exr -o out.png --focus-at 960,540 --f-stop 1.4
  heatlens render plate.exr -o quick.png --f-stop 2 --focus-distance 6ft3in \\
      --quality draft --proxy 0.5
  heatlens render plate.exr -o scatter.exr --f-stop 2 --focus-distance 2.24 --method scatter
  heatlens render scene.glb -o truth.exr --size 1280x720 --method accumulation --views 1024 \\
      --f-stop 2 --focus-distance 3
  heatlens render scene.glb -o pinhole.exr --pinhole
  heatlens render scene.glb -o plate.exr --pinhole --overscan auto --deep --f-stop 2 \\
      --focus-distance 3
  heatlens render demo -o demo.png --frame 120
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    add_frame_options(parser, _add_output_options, add_blur_options)


def _add_output_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        help=f"the picture: .exr, or as displayed and without overscan {words_written()}; - is an "
        "EXR on standard output. Replaces an existing file, and makes one missing folder",
    )
    parser.add_argument(
        "--behind-out",
        type=Path,
        metavar="FILE",
        help="with --neighbours: also write the hidden surfaces that were found (RGBA and Z) to "
        "clean.exr or clean.####.exr, a clean plate for --behind",
    )
    add_pinhole_options(parser)
    parser.add_argument("--float", action="store_true", help="32-bit float EXR (default: half)")
    parser.add_argument(
        "--compression", choices=COMPRESSIONS, help="for EXR (default: as in the plate, or zip)"
    )
    add_keep_option(parser)
    add_device_option(parser)
    parser.add_argument("--stats", action="store_true", help="print the time of each step")
    add_display_options(parser)


def run(args: argparse.Namespace) -> int:
    """Read, render and write a picture; print all decisions."""
    is_piped = str(args.output) == DASH
    with stdin_as_file(args.plate) as plate, file_for_output(args.output) as output:
        args.plate, args.output = plate, output
        _render(args)
    if not is_piped:
        print_result(str(args.output))
    return 0


def _check_arguments(args: argparse.Namespace) -> DefocusSettings:
    """Return the blur settings. Raises InputError for impossible outputs and useless options."""
    choose_one_frame(args)
    other_inputs = [*([] if args.depth is None else [args.depth]), *(args.behind or [])]
    check_output(args.output, *files_of_scene(args.plate), *map(Path, other_inputs))
    _refuse_look_for_exr(args)
    check_pinhole_options(args, _is_exr(args))
    settings = settings_of(args)
    refuse_unused_options(args, str(args.plate), settings.method)
    return settings


def _render(args: argparse.Namespace) -> None:
    """Load the plate or scene, render it and write the picture; print messages."""
    start_s = time.perf_counter()
    settings = _check_arguments(args)
    channel_names = _channels_to_keep(args, settings)
    display = _display_settings_of_output(args)
    use_device(args)
    renderer = headless_renderer()
    renderer.stopwatch.is_on = args.stats
    shot, frame = commands_for(args.plate).load(args, renderer, settings)
    _check_disk_space(args, shot, renderer)
    read_s = time.perf_counter()
    with picture_progress(renderer, shot) as report_step:
        plate, pixels = _make_picture(args, renderer, shot, frame, report_step)
    if not _is_exr(args):
        print_messages(*_squeeze_messages(args, plate))
    if renderer.has_many_views:
        print_messages(*renderer.loaded.plate.notes)
    render_s = time.perf_counter()
    lens = shot.lens_at(frame)
    if args.deep:
        make_folder(args.output.parent)
        attributes = {**plate.attributes, **lens_header(plate, lens), **blurred_mark(False)}
        write_deep(args.output, plate, attributes, half=not args.float)
    else:
        plate_channels, plate_attributes = read_kept_channels(
            plate, plate_options(args), channel_names
        )
        write_picture(
            *(args.output, pixels, plate, lens, settings.proxy),
            half=not args.float,
            compression=args.compression or plate.compression or "zip",
            encode=encode_srgb if display is None else _encode_function(display, renderer),
            more_channels=_depth_channel(args, plate),
            more_attributes=plate_attributes,
            kept_channels=plate_channels,
            is_blurred=not args.pinhole,
        )
    if args.stats:
        _print_stats(renderer, (start_s, read_s, render_s, time.perf_counter()))


def _squeeze_messages(args: argparse.Namespace, plate: Plate) -> tuple[str, ...]:
    """Return a message for a picture with pixels that are not square, which looks squeezed."""
    aspect = plate.pixel_aspect_ratio
    if aspect == 1.0:
        return ()
    return (
        f"the pixels of {plate.path} are {aspect:g} times as wide as high, so {args.output} is "
        f"squeezed: `heatlens export` with --desqueeze {aspect:g} widens it.",
    )


def _depth_channel(args: argparse.Namespace, plate: Plate) -> dict[str, FloatArray]:
    """Return the depth channel of a picture without a lens."""
    return {"Z": plate.depth_m} if args.pinhole and plate.depth_m is not None else {}


def _check_disk_space(args: argparse.Namespace, shot: Shot, renderer: FrameRenderer) -> None:
    """Raise InputError if the disk has less space than the compressed picture needs."""
    width, height = renderer.size(shot)
    values = 4 * width * height * shot.defocus.proxy**2
    needed_bytes = values * (4 if args.float else 2) * _COMPRESSED_SHARE if _is_exr(args) else 0.0
    check_space(args.output.absolute().parent, needed_bytes, "the picture")


def _make_picture(
    args: argparse.Namespace,
    renderer: FrameRenderer,
    shot: Shot,
    frame: int,
    report_step: Callable[[str], None],
) -> tuple[Plate, FloatArray]:
    """Return the plate and the pixels to write."""
    if args.pinhole:
        plate = render_pinhole_plate(args, renderer, shot, frame)
        return plate, plate.color
    pixels = download(run_all_steps(renderer.steps(shot, frame), report_step))
    return renderer.loaded.plate, pixels


def _is_exr(args: argparse.Namespace) -> bool:
    return bool(args.output.suffix.lower() == ".exr")


def _refuse_look_for_exr(args: argparse.Namespace) -> None:
    """Raise InputError for options of the display if the output is an EXR."""
    look_options = changed_options(args, add_display_options)
    if look_options and _is_exr(args):
        if args.ocio is not None:
            load_color_config(args.ocio)  # report a missing file before all else
        raise InputError(
            f"{', '.join(look_options)}: an EXR stays scene-linear for further work. Write a PNG "
            "in "
            "addition."
        )


def _channels_to_keep(args: argparse.Namespace, settings: DefocusSettings) -> tuple[str, ...]:
    """Return the channels to keep; refuse options that need an EXR of a plate at full size."""
    exr_options = {"--compression": args.compression, "--keep-channels": args.keep_channels}
    given_names = [option for option, value in exr_options.items() if value]
    if given_names and not _is_exr(args):
        raise InputError(
            f"{', '.join(given_names)}: only an EXR holds this, and {args.output} is none. Give a "
            "name that ends in .exr."
        )
    if not args.keep_channels:
        return ()
    options = plate_options(args)
    return parse_kept_channels(args, single_source(args.plate, options), options, settings.proxy)


def _display_settings_of_output(args: argparse.Namespace) -> DisplaySettings | None:
    """Return the display settings of the output; None for an EXR, which stays scene-linear."""
    if _is_exr(args):
        return None
    options = plate_options(args)
    header = color_header(single_source(args.plate, options).first_file, options)
    return display_settings(args, header)


def _encode_function(display: DisplaySettings, renderer: FrameRenderer) -> Encode:
    """Return the function that encodes light for the output by the view transform."""
    print_view_transform(display.transform)
    return DisplayValues(
        renderer.ctx, display.transform, display.exposure_stops, display.gamma
    ).encode


def _print_stats(renderer: FrameRenderer, times_s: tuple[float, float, float, float]) -> None:
    """Print the times of reading, rendering and writing, and of each render step."""
    read_ms, render_ms, write_ms = (1e3 * (end_s - begin_s) for begin_s, end_s in pairwise(times_s))
    print_messages(f"read {read_ms:.0f} ms, render {render_ms:.0f} ms, write {write_ms:.0f} ms")
    print_messages(f"on {renderer.ctx.name}, solver {renderer.solver.name}")
    for name, entry in renderer.stopwatch.times.items():
        print_messages(f"  {name:24} {1e3 * entry.seconds:8.1f} ms  {entry.runs:3d} x")
