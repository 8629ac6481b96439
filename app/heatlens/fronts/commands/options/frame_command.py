"""The options and the check that all commands on one frame of a plate or a 3D scene share."""

import argparse
import os
from collections.abc import Callable
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.fronts.commands.options.lens_options import add_lens_options, add_plate_options
from heatlens.fronts.commands.options.one_of_many import check_frame_of_file, names_picture
from heatlens.fronts.commands.options.scene_options import add_framing_options
from heatlens.fronts.commands.options.value_types import parse_whole_number
from heatlens.media.documents.shot_file import is_shot_file
from heatlens.media.files.picture_formats import parse_movie_name
from heatlens.media.sequence.names import frames_text, parse_pattern
from heatlens.media.sequence.sequence_search import find_sequence

AddOptions = Callable[[argparse.ArgumentParser], None]


def add_frame_options(
    parser: argparse.ArgumentParser, add_own_options: AddOptions, add_blur: AddOptions
) -> None:
    """Add the plate, the options of the command itself, the lens, the blur and the scene."""
    parser.add_argument(
        "plate",
        type=Path,
        help="EXR with colour and depth, or - for one on standard input; a movie; or a scene: "
        ".glb, .gltf, .obj, .ply, .stl, .usd; or demo",
    )
    add_own_options(parser)
    add_lens_options(parser)
    add_blur(parser)
    add_plate_options(parser)
    group = add_framing_options(parser)
    group.add_argument(
        "--frame",
        type=parse_whole_number,
        metavar="N",
        help="frame to show, also of a movie or of 'plate.####.exr' (default: first)",
    )


def choose_one_frame(args: argparse.Namespace) -> None:
    """Replace a sequence or movie in `args.plate` by the one file that --frame chooses.

    Raises InputError for a shot, and for a sequence without --frame. The error names the command
    that can be used instead.
    """
    path = args.plate
    if is_shot_file(str(path)):
        raise InputError(
            f"{path} is a shot file: `heatlens export {path} -o 'frame.####.exr' --frames N` "
            "renders its frame N, and without --frames all of them."
        )
    is_pattern = not os.path.exists(path) and parse_pattern(path.name) is not None
    is_many = is_pattern or os.path.isdir(path) or parse_movie_name(path) is not None
    if is_many and args.frame is not None:
        sequence, frame = find_sequence(path), args.frame
        if not sequence.has_file(frame):
            present_frames = frames_text(sequence.present)
            raise InputError(f"{path} has no frame {frame}: there are {present_frames}.")
        args.plate, args.frame = sequence.path_at(frame), None
    elif args.frame is not None and not is_pattern and names_picture(path):
        check_frame_of_file(str(path), args.frame)
        args.frame = None
    elif is_pattern or os.path.isdir(path):
        kind = "a sequence" if is_pattern else "a folder"
        raise InputError(
            f"{path} is {kind}: use `heatlens export` to render the frames of a sequence, or name "
            "one frame here, as with --frame N."
        )
