"""`heatlens info`: print what is in a file and how heatlens would read it."""

import argparse
import json

from heatlens.base.errors import InputError
from heatlens.base.printable import printable
from heatlens.commands.options.plate_options import add_plate_options, plate_options
from heatlens.commands.options.scene_options import add_placing_options
from heatlens.commands.options.value_types import number
from heatlens.commands.output.say import tell
from heatlens.commands.sources.info_sequence import found_among, lacks_frames, sequence_info
from heatlens.commands.sources.source_commands import Facts, Line, commands_for
from heatlens.documents.shot_file import is_shot_file
from heatlens.sequence.sequence import Sequence

_DESCRIPTION = """\
Prints what a render holds and how heatlens would read it: size and windows (pixels), channels, the
lens in the header (focal length and sensor in mm, focus in metres), the primaries of the colours,
the range of the depth (metres), and how the depth is interpreted and why. Try the depth options
here before a render.

For several frames (shot.####.exr, a folder, or a list of files): which frames exist and which are
missing, their sizes, how their depth is read, and its range over the shot.

For a 3D scene: its cameras, frames, objects, triangles, lights and size.

The exit code is 1 if frames of a sequence are missing, or cannot be rendered because they are
damaged or have no depth, so that a farm can check plates before it renders. A single file that can
be read gives 0, also without depth.

--json writes lengths in metres and millimetres as the names say. A window is [x0, y0, x1, y1] with
x1 and y1 behind the last pixel: [0, 0, 320, 180] has 320 x 180 pixels. The text names the last
pixel, (319, 179), as the EXR header does. width_px and height_px are the size of the data window,
display_width_px and display_height_px that of the display window.
"""

_LABEL_WIDTH = 16


def register(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add `info` to the command line."""
    parser = commands.add_parser(
        "info",
        help="show the contents of a render or a 3D scene, and how its depth is read",
        description=_DESCRIPTION,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "plates",
        nargs="+",
        metavar="PLATE",
        help="one or more renders; a sequence; a folder; a 3D scene; or demo",
    )
    parser.add_argument(
        "--json", action="store_true", help="the same as JSON, for programs; see above"
    )
    add_plate_options(parser)
    lens = parser.add_argument_group("the lens, for --depth-kind radial without one in the header")
    lens.add_argument("--focal-length", type=number, metavar="MM", help="focal length in mm")
    lens.add_argument("--sensor-width", type=number, metavar="MM", help="width of the sensor in mm")
    add_placing_options(parser.add_argument_group("a 3D scene whose file does not say it"))
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Print the facts; the exit code is 1 if frames of a sequence are missing or damaged."""
    found = [_facts_of(args, item) for item in found_among(args.plates)]
    if args.json:
        facts = [item[0] for item in found]
        tell(json.dumps(facts if len(facts) > 1 else facts[0], indent=2, allow_nan=False), "\n")
    else:
        tell("\n\n".join(_text(lines) for _, lines in found), "\n")
    return int(any(lacks_frames(facts) for facts, _ in found))


def _facts_of(args: argparse.Namespace, item: str | Sequence) -> tuple[Facts, list[Line]]:
    if isinstance(item, Sequence):
        return sequence_info(item, plate_options(args))
    if is_shot_file(item):
        raise InputError(f"{item} is a shot file: `heatlens shot show {item}` prints it.")
    return commands_for(item).info(args, item)


def _text(lines: list[Line]) -> str:
    """Return the lines as text with aligned labels."""
    return "\n".join(f"{label:<{_LABEL_WIDTH}}{printable(str(value))}" for label, value in lines)
