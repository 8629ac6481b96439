"""`heatlens camera`: export the lens of a shot to the programs that make the final render."""

import argparse
import os
from collections.abc import Callable
from itertools import cycle
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange, parse_frame_range
from heatlens.core.model.depth_words import DepthConvention
from heatlens.core.model.timecode import Timecode
from heatlens.core.model.units import parse_scene_unit_m
from heatlens.fronts.commands.options.given_options import refuse_options
from heatlens.fronts.commands.options.lens_options import lens_words
from heatlens.fronts.commands.options.scene_options import add_timing_options, given_timing
from heatlens.fronts.commands.options.value_types import parse_number
from heatlens.fronts.commands.output.plate_words import shot_timecodes
from heatlens.fronts.commands.output.say import print_messages, print_result
from heatlens.fronts.commands.shots.following import measure_live_focus
from heatlens.media.camera.camera_file import (
    CAMERA_SUFFIXES,
    read_camera,
    unsupported_notes,
    write_camera,
)
from heatlens.media.camera.ring_samples import ring_samples
from heatlens.media.camera.samples import CameraSamples, with_nominal_f_stop, with_renderer_f_stop
from heatlens.media.camera.usd_read import USD_SUFFIXES, split_prim
from heatlens.media.documents.shot_file import SHOT_SUFFIX, is_shot_file, read_shot
from heatlens.media.live.ring.address import RingAddress, opentrackio_address
from heatlens.media.live.ring.opentrackio import Encoding
from heatlens.media.live.ring.sender import LensSender, send_at_rate
from heatlens.media.scene.first_shot import FirstShot, first_shot
from heatlens.render.source.named import camera_of_shot, has_camera

DESCRIPTION = """\
Writes the lens of a shot at each frame: focal length, f-stop, focus and sensor. It also writes the
position of the camera, if the plate's headers have it (worldToCamera) or the source is a 3D scene.
The extension of the output decides the format:

  .usda .usd .usdc   UsdGeomCamera, with time samples for values that change
  .nk                a Camera2 node for Nuke
  .py                a script that sets the lens of Blender's active camera, or makes a camera
  .json .csv         for other programs, with units in the names

Instead of a shot you can give a camera in USD, in such JSON or CSV, or in the headers of EXR files,
or a scene (glTF, OBJ, PLY, STL, demo), whose first camera is used. Focus at infinity is written as
1e9 m in formats that have no infinity.

The discs of a real lens are larger than those of a CG renderer at the same f-stop, by S/(S - f) for
the focus S and the focal length f. The camera of a photographic shot therefore carries the f-stop
that makes the same discs in a renderer, at every frame, and the nominal one beside it.
"""
_TIMING_OPTIONS = ("clip", "first_frame", "fps")
_SAME_DISCS, _NOMINAL = "same-discs", "nominal"
EPILOG = """\
examples:
  heatlens camera s.heatlens.json -o cam.usda
  heatlens camera s.heatlens.json -o cam.nk --frames 1001-1024 --meters-per-unit cm
  heatlens camera shot.usda:/world/cam -o cam.csv
  heatlens camera s.heatlens.json --send opentrackio --repeat
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "source", metavar=f"SHOT{SHOT_SUFFIX}", help="the shot, a scene or a camera"
    )
    parser.add_argument(
        "-o", "--output", type=Path, help=f"camera to write: *{', *'.join(CAMERA_SUFFIXES)}"
    )
    _add_send_options(parser)
    _add_shot_options(parser)
    parser.add_argument(
        "--meters-per-unit",
        metavar="UNIT",
        help="unit of the scene that the camera is for: m, cm, mm, ft, in, or a number of metres "
        "(default: cm for USD, which is its own default, and m for Nuke)",
    )
    parser.add_argument(
        "--f-stop",
        choices=(_SAME_DISCS, _NOMINAL),
        help="f-stop of a photographic lens: the one that makes the same discs in a CG renderer, "
        f"and the nominal one beside it (default), or only the {_NOMINAL} one (always with --send)",
    )


def _add_send_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("sending live", "Instead of a file, or in addition to it.")
    group.add_argument(
        "--send",
        metavar="PROTOCOL[://HOST:PORT]",
        help="play the lens in real time to another heatlens, an engine or a follow-focus: "
        "opentrackio for this machine, or opentrackio://HOST:PORT",
    )
    group.add_argument("--repeat", action="store_true", help="repeat until Ctrl-C")
    group.add_argument(
        "--encoding",
        choices=[it.name.lower() for it in Encoding],
        help="for --send (default: json)",
    )


def _add_shot_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("the shot and its plate")
    group.add_argument(
        "--frames", metavar="FIRST-LAST", help="default: those that the shot plays, in to out"
    )
    group.add_argument(
        "--sensor-height",
        type=parse_number,
        metavar="MM",
        help="default: from the aspect ratio of the plate; without a plate, that of the film back "
        "of that width, or 16:9",
    )
    group.add_argument(
        "--scene-unit",
        metavar="UNIT",
        help="unit of the camera positions in the headers (default: as the shot reads "
        "the plate's depth)",
    )
    group.add_argument("--up-axis", choices=("y", "z"), help="up axis of that world (default y)")
    add_timing_options(parser.add_argument_group("3D scene"))


def run(args: argparse.Namespace) -> int:
    """Write the camera and send it; print its origin and any assumptions."""
    _check_options(args)
    address = None if args.send is None else opentrackio_address(args.send)
    camera = _read_samples(args)
    if args.output is None:
        print_messages(*camera.notes)
    else:
        _write_file(args, camera)
    if address is not None:
        _send(args, camera, address)
    return 0


def _check_options(args: argparse.Namespace) -> None:
    """Refuse a command that would do nothing, and options without effect."""
    if args.output is None and args.send is None:
        raise InputError("Give a file to write with -o, or an address to send to with --send.")
    if args.send is None and (args.repeat or args.encoding):
        raise InputError("--repeat and --encoding need --send.")
    if args.output is None and (args.f_stop or args.meters_per_unit):
        raise InputError("--f-stop and --meters-per-unit need a file to write, given with -o.")


def _send(args: argparse.Namespace, camera: CameraSamples, address: RingAddress) -> None:
    """Send the lens of every frame to `address` in real time; with --repeat, until Ctrl-C."""
    rate = camera.frames_per_second
    encoding = Encoding[(args.encoding or "json").upper()]
    samples = ring_samples(camera, _timecode_function(args, camera))
    with LensSender(address, encoding) as sender:
        times = "repeatedly, until Ctrl-C" if args.repeat else f"{len(samples) / rate:.1f} s"
        print_messages(f"sending {len(samples)} frames at {rate:g}/s to {sender.address}: {times}")
        send_at_rate(sender, cycle(samples) if args.repeat else samples, rate)


def _timecode_function(
    args: argparse.Namespace, camera: CameraSamples
) -> Callable[[int], Timecode | None]:
    """Return a function that gives the timecode of a frame, for shots and shoot tables."""
    if is_shot_file(args.source):
        return shot_timecodes(read_shot(args.source), camera.frames[0])
    timecodes = dict(zip(camera.frames, camera.timecodes or (), strict=False))
    return timecodes.get


def _write_file(args: argparse.Namespace, camera: CameraSamples) -> None:
    """Write the camera file with the requested f-stop and unit; print its name and all notes."""
    if args.f_stop == _NOMINAL:
        camera = with_nominal_f_stop(camera)
    else:
        camera = with_renderer_f_stop(camera)
    unit = args.meters_per_unit
    unit_m = None if unit is None else parse_scene_unit_m(unit)
    write_camera(args.output, camera, unit_m, _has_inverse_depth(args.source))
    print_messages(*camera.notes, *unsupported_notes(args.output, camera))
    print_result(str(args.output))


def _has_inverse_depth(source: str) -> bool:
    """Return True for a shot whose plate holds 1/z."""
    if not is_shot_file(source):
        return False
    return read_shot(source).plate_options.depth_convention is DepthConvention.INVERSE


def _read_samples(args: argparse.Namespace) -> CameraSamples:
    """Return the camera of a scene, a shot or a camera file; refuse options without effect."""
    unit_m = None if args.scene_unit is None else parse_scene_unit_m(args.scene_unit)
    if _is_scene(args.source):
        first = first_shot(args.source, timing=given_timing(args, args.source))
        print_messages(*_scene_messages(first))
        shot = first.shot
    elif is_shot_file(args.source):
        refuse_options(args, _TIMING_OPTIONS, f"{args.source} sets how its scene is played")
        shot = measure_live_focus(read_shot(args.source))
    else:
        refuse_options(args, _TIMING_OPTIONS, f"{args.source} is not a 3D scene")
        _refuse_shot_options(args)
        camera = read_camera(args.source, unit_m or 1.0, args.up_axis or "y")
        _check_frames(args, camera)
        return camera
    if has_camera(shot.source):
        reason = f"{shot.source} is a 3D scene, in metres and y up"
        refuse_options(args, ("scene_unit", "up_axis"), reason)
    return camera_of_shot(
        shot,
        Path(args.source).name.removesuffix(SHOT_SUFFIX),
        parse_frame_range(args.frames) if args.frames else None,
        args.sensor_height,
        unit_m,
        args.up_axis or "y",
    )


def _is_scene(source: str) -> bool:
    """Return True for a scene, but not for USD, which is read as a camera file.

    A USD file may hold nothing but a camera.
    """
    path, _ = split_prim(source)
    return has_camera(source) and path.suffix.lower() not in USD_SUFFIXES


def _scene_messages(first: FirstShot) -> tuple[str, ...]:
    """Return the notes of the scene, and a message on its lens, which is partly assumed."""
    lens = first.shot.lens_at(first.frame)
    return (*first.scene.notes, lens_words(f"lens at frame {first.frame}", lens, first.sources))


def _check_frames(args: argparse.Namespace, camera: CameraSamples) -> None:
    """Raise InputError for --frames that are not all frames of the camera file."""
    camera_frames = FrameRange(camera.frames[0], camera.frames[-1])
    if args.frames and parse_frame_range(args.frames) != camera_frames:
        raise InputError(
            f"--frames {args.frames} is for shots; {args.source} is already a camera, with frames "
            f"{camera_frames}: leave --frames out."
        )


def _refuse_shot_options(args: argparse.Namespace) -> None:
    """Refuse options of a shot for a camera file, and an output that is the camera file."""
    if args.sensor_height is not None:
        raise InputError(
            f"--sensor-height is for shots, and {args.source} is already a camera: leave it out."
        )
    if args.output is not None and args.output.exists() and os.path.exists(args.source):
        if os.path.samefile(args.output, args.source):
            raise InputError(f"{args.output} is the input camera: give another name.")
