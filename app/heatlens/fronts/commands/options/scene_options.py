"""The options for viewing a 3D scene, and the first shot of a scene with these options.

Some options convert the seconds of a glTF scene to frames, and choose the animation.
"""

import argparse
import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FRAMES_PER_SECOND, check_within
from heatlens.core.model.shot.framing import Framing, SceneTiming, WorldAxis
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.units import parse_scene_unit_m
from heatlens.fronts.commands.options.kit_options import shot_with_kit
from heatlens.fronts.commands.options.lens_options import (
    given_lens_fields,
    lens_words,
    parse_pixel,
    value_origins,
)
from heatlens.fronts.commands.options.value_types import parse_number, parse_whole_number
from heatlens.media.plate.coc_line import focused_at_pixel

if TYPE_CHECKING:  # commands on plates have some of these options too
    from heatlens.media.scene.first_shot import FirstShot
    from heatlens.media.scene.placing import Placing
    from heatlens.render.frame_renderer import FrameRenderer

_FOCUS_FIELD = "focus_distance_m"
_SUFFIXES_WITH_SECONDS = (".glb", ".gltf")


def add_framing_options(
    parser: argparse.ArgumentParser, has_rate: bool = False
) -> "argparse._ArgumentGroup":
    """Add --size, --scene-camera and the options of its timing; return their group.

    `has_rate` says that the command has an option --fps already.
    """
    group = parser.add_argument_group("3D scene", "How the scene is viewed; not for plates.")
    group.add_argument(
        "--size", type=parse_size, metavar="WxH", help="size of the picture (default 1280x720)"
    )
    group.add_argument(
        "--scene-camera",
        metavar="NAME",
        help="camera of the scene to use (default: the first; without any, the view shows the "
        "whole scene)",
    )
    add_timing_options(group, has_rate)
    add_placing_options(group)
    return group


def add_placing_options(group: "argparse._ArgumentGroup") -> None:
    """Add --up-axis and --meters-per-unit."""
    group.add_argument(
        "--up-axis",
        type=parse_axis,
        metavar="x|y|z",
        help="up axis of a PLY, STL or OBJ, which do not define it (default: a guess)",
    )
    group.add_argument(
        "--meters-per-unit",
        type=parse_unit,
        metavar="UNIT",
        help="unit of a PLY, STL or OBJ: m, cm, mm, ft, in, or a number of metres (default: a "
        "guess by its size)",
    )


def given_placing(args: argparse.Namespace) -> "Placing":
    """Return the given up axis and unit for a scene whose file does not define them."""
    from heatlens.media.scene.placing import Placing

    return Placing(args.up_axis, args.meters_per_unit)


def parse_axis(text: str) -> WorldAxis:
    """Parse x, y or z; argparse turns the error into its own sentence."""
    try:
        return WorldAxis(text.lower())
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is none of x, y and z.") from None


def parse_unit(text: str) -> float:
    """Parse a unit to meters; argparse turns the error into its own sentence."""
    try:
        return parse_scene_unit_m(text)
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def parse_size(text: str) -> tuple[int, int]:
    """Parse WxH; argparse turns the error into its own sentence."""
    match = re.fullmatch(r"(\d{1,6})x(\d{1,6})", text)
    size = (int(match[1]), int(match[2])) if match else (0, 0)
    if min(size) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a size in pixels. Example: 1920x1080")
    return size


def shot_of_scene(args: argparse.Namespace, text: str) -> "FirstShot":
    """Return the first shot of the scene `text` with the lens and the framing of the options.

    Raises InputError if the scene cannot be read or has no such camera, or the lens lacks a value.
    """
    if args.focus_at is not None:
        raise InputError(
            "--focus-at needs a picture, and a scene has none until it is rendered: give "
            "--focus-distance."
        )
    return _check_lens(args, text, _first_shot(args, text))


def load_scene(
    args: argparse.Namespace, renderer: "FrameRenderer", defocus: DefocusSettings
) -> tuple[Shot, int, tuple[str, ...]]:
    """Load the scene that `args.plate` names to the GPU.

    Return the shot, the frame, and messages on the scene and the lens. Raises InputError if the
    scene cannot be read or has no such frame, or the lens is not complete.
    """
    text = str(args.plate)
    first = _first_shot(args, text)
    frame = first.frame if args.frame is None else args.frame
    check_within(first.shot.frames, text, (frame,))
    renderer.load_scene(first.scene)
    if args.focus_at is not None:
        plate = renderer.load_pinhole(first.shot, frame).plate
        focused_lens = focused_at_pixel(
            plate, first.shot.lens_at(frame), *parse_pixel(args.focus_at)
        )
        first = _first_shot(args, text, {_FOCUS_FIELD: focused_lens.focus_distance_m})
    _check_lens(args, text, first)
    messages = (*first.scene.notes, lens_message(args, first, frame))
    return replace(first.shot, defocus=defocus), frame, messages


def with_framing(args: argparse.Namespace, shot: Shot) -> Shot:
    """Return the shot with the given size and camera."""
    framing = shot.framing or Framing()
    if args.size is not None:
        framing = replace(framing, width_px=args.size[0], height_px=args.size[1])
    if args.scene_camera is not None:
        framing = replace(framing, camera=args.scene_camera, track=None)
    if args.up_axis is not None:
        framing = replace(framing, up_axis=args.up_axis)
    if args.meters_per_unit is not None:
        framing = replace(framing, meters_per_unit=args.meters_per_unit)
    return replace(shot, framing=framing)


def lens_message(args: argparse.Namespace, first: "FirstShot", frame: int) -> str:
    """Return a message on the lens at a frame, with the origin of each value."""
    sources = {**first.sources, **value_origins(args)}
    return lens_words(f"lens at frame {frame}", first.shot.lens_at(frame), sources)


def _first_shot(
    args: argparse.Namespace, text: str, measured_fields: dict[str, object] | None = None
) -> "FirstShot":
    """Return the first shot of a scene with the given lens and `measured_fields`."""
    from heatlens.media.scene.first_shot import first_shot

    lens = {**given_lens_fields(args), **(measured_fields or {})}
    timing, placing = given_timing(args, text), given_placing(args)
    first = first_shot(text, args.size, args.scene_camera, lens, timing, placing)
    return replace(first, shot=shot_with_kit(args, first.shot))


def _check_lens(args: argparse.Namespace, text: str, first: "FirstShot") -> "FirstShot":
    """Return `first` unchanged. Raises InputError if its f-stop or focus is only assumed.

    A picture without a lens needs neither.
    """
    needed_options = {"f_stop": "--f-stop", _FOCUS_FIELD: "--focus-distance"}
    missing_options = [option for name, option in needed_options.items() if name in first.assumed]
    if missing_options and not getattr(args, "pinhole", False):
        option_list = " and ".join(missing_options)
        raise InputError(f"{text}: the scene does not define the whole lens. Give {option_list}.")
    return first


def add_timing_options(group: "argparse._ArgumentGroup", has_rate: bool = False) -> None:
    """Add --clip, --first-frame and --fps; `has_rate` says that the command already has --fps."""
    group.add_argument(
        "--clip",
        metavar="NAME",
        help="animation of a glTF to play, by name or number (`info` lists them; default: all at "
        "once)",
    )
    group.add_argument(
        "--first-frame",
        type=parse_whole_number,
        metavar="N",
        help="frame number of the first key of a glTF (default: second 0 is frame 1), or of the "
        "first frame of a movie (default 1). Blender's frames 101 to 126 at 25 a second are "
        "--fps 25 --first-frame 101",
    )
    if not has_rate:
        group.add_argument(
            "--fps",
            type=parse_number,
            metavar="N",
            help=f"frames per second of a glTF (default {FRAMES_PER_SECOND:g})",
        )
        group.set_defaults(is_rate_of_scene=True)


def given_timing(args: argparse.Namespace, text: str) -> SceneTiming | None:
    """Return the timing that was given for the scene `text`; None for the default timing.

    A frame rate given for another purpose also applies to a scene that has no frames of its own.
    Raises InputError for an impossible rate.
    """
    rate, has_seconds = args.fps, Path(text).suffix.lower() in _SUFFIXES_WITH_SECONDS
    if not has_seconds and not getattr(args, "is_rate_of_scene", False):
        rate = None
    if args.clip is None and args.first_frame is None and rate is None:
        return None
    rate = FRAMES_PER_SECOND if rate is None else rate
    return SceneTiming(args.clip, rate, args.first_frame)
