"""The options that put the seconds of a glTF scene into frames, and choose what is played."""

import argparse
from pathlib import Path

from heatlens.commands.options.value_types import number, whole
from heatlens.model.frames import FRAMES_PER_SECOND
from heatlens.model.framing import SceneTiming

_WITH_SECONDS = (".glb", ".gltf")


def add_timing_options(group: "argparse._ArgumentGroup", has_rate: bool = False) -> None:
    """Add --clip, --first-frame and --fps; `has_rate` where the command has an --fps already."""
    group.add_argument(
        "--clip",
        metavar="NAME",
        help="animation of a glTF that is played, by its name or its number (`info` lists them; "
        "default: all at once)",
    )
    group.add_argument(
        "--first-frame",
        type=whole,
        metavar="N",
        help="frame at the first key of a glTF (default: frame 1 is its second 0). Blender's "
        "frames 101 to 126 at 25 a second are --fps 25 --first-frame 101",
    )
    if not has_rate:
        group.add_argument(
            "--fps",
            type=number,
            metavar="N",
            help=f"frames of a second of a glTF (default {FRAMES_PER_SECOND:g})",
        )
        group.set_defaults(is_rate_of_scene=True)


def timing_of(args: argparse.Namespace, text: str) -> SceneTiming | None:
    """Return the timing that was given for the scene `text`, None for the usual one.

    A frame rate given for another purpose also applies to a scene that has no frames of its own.
    Raises InputError for an impossible rate.
    """
    rate, has_seconds = args.fps, Path(text).suffix.lower() in _WITH_SECONDS
    if not has_seconds and not getattr(args, "is_rate_of_scene", False):
        rate = None
    if args.clip is None and args.first_frame is None and rate is None:
        return None
    rate = FRAMES_PER_SECOND if rate is None else rate
    return SceneTiming(args.clip, rate, args.first_frame)
