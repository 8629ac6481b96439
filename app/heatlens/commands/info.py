"""`heatlens info`: print what is in a file and how heatlens would read it."""

import argparse
import json
from pathlib import Path
from typing import Any

from heatlens.color.color_config import PLAIN_OCIO_VIEW
from heatlens.commands.given_options import refuse_given, refuse_unused
from heatlens.commands.info_scene import Line, scene_lines
from heatlens.commands.info_sequence import found_among, lacks_frames, sequence_info
from heatlens.commands.pipes import file_of_input
from heatlens.commands.plate_options import add_plate_options, plate_options
from heatlens.commands.say import tell
from heatlens.commands.scene_options import add_placing_options, placing_of
from heatlens.commands.value_types import number
from heatlens.documents.shot_file import is_shot_file
from heatlens.errors import InputError
from heatlens.model.lens_model import LensModel
from heatlens.plate.inspection import inspect
from heatlens.printable import printable
from heatlens.scene.first_shot import first_shot
from heatlens.scene.scene_facts import scene_facts
from heatlens.sequence.sequence import Sequence
from heatlens.source.kind import SourceKind, kind_of

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

_CAMERA_LINES = (
    ("focal length", "focal_length_mm", "mm"),
    ("f-stop", "f_stop", ""),
    ("T-stop", "t_stop", ""),
    ("focus distance", "focus_distance_m", "m"),
    ("sensor width", "sensor_width_mm", "mm"),
    ("sensor height", "sensor_height_mm", "mm"),
    ("lens model", "model", ""),
)
_FOR_THE_EYE = (
    f"{PLAIN_OCIO_VIEW}, if the config has it, unless --view is given: the picture is "
    "display-referred, and its tones are mapped already"
)
_LABEL_WIDTH = 16


def register(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add `info` to the command line."""
    parser = commands.add_parser(
        "info",
        help="say what a render or a 3D scene holds, and how depth would be read",
        description=_DESCRIPTION,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "plates",
        nargs="+",
        metavar="PLATE",
        help="the render to look at, or several; a sequence; a folder; a 3D scene; or demo",
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


def _facts_of(args: argparse.Namespace, item: str | Sequence) -> tuple[dict[str, Any], list[Line]]:
    if isinstance(item, Sequence):
        return sequence_info(item, plate_options(args))
    if is_shot_file(item):
        raise InputError(f"{item} is a shot file: `heatlens shot show {item}` prints it.")
    if kind_of(item) is SourceKind.SCENE:
        return _of_scene(args, item)
    with file_of_input(Path(item)) as path:
        facts = inspect(path, plate_options(args))
    return facts, _plate_lines(facts)


def _of_scene(args: argparse.Namespace, text: str) -> tuple[dict[str, Any], list[Line]]:
    refuse_unused(args, text, SourceKind.SCENE)
    lens = ("focal_length", "sensor_width")
    refuse_given(args, lens, f"{text} is a 3D scene, and that is for depth along rays")
    facts = scene_facts(first_shot(text, placing=placing_of(args)))
    return facts, scene_lines(facts)


def _text(lines: list[Line]) -> str:
    """Return the lines as text with aligned labels."""
    return "\n".join(f"{label:<{_LABEL_WIDTH}}{printable(str(value))}" for label, value in lines)


def _plate_lines(facts: dict[str, Any]) -> list[Line]:
    return [
        ("file", facts["path"]),
        ("size", f"{facts['width_px']} x {facts['height_px']} px"),
        ("data window", _window(facts["data_window"])),
        ("display window", _window(facts["display_window"])),
        ("pixel aspect", f"{facts['pixel_aspect_ratio']:g}"),
        *([("views", ", ".join(facts["views"]))] if facts["views"] else []),
        *_part_lines(facts["parts"]),
        *_camera_lines(facts["camera"]),
        *_primaries_lines(facts["primaries"]),
        *([("seen through", _FOR_THE_EYE)] if facts["is_for_the_eye"] else []),
        *_color_lines(facts["color"]),
        *_depth_lines(facts["depth"]),
        *_behind_lines(facts["behind"]),
        *(("note", note) for note in _notes(facts)),
    ]


def _notes(facts: dict[str, Any]) -> list[str]:
    """Return the notes without the reading of the depth and its reason, which have their lines."""
    why, question = (facts["depth"].get(name, "") for name in ("why", "question"))
    notes = (
        note.removesuffix(why).rstrip() * bool(question) if why and note.endswith(why) else note
        for note in facts["notes"]
    )
    return [note for note in notes if note]


def _window(corners: list[int]) -> str:
    """Format the first and the last pixel of a window, as other EXR tools do."""
    x0, y0, x1, y1 = corners
    return f"({x0}, {y0}) to ({x1 - 1}, {y1 - 1})"


def _part_lines(parts: list[dict[str, Any]]) -> list[Line]:
    """Return one line for each part and one for each type of channel in it."""
    lines = []
    for count, part in enumerate(parts, start=1):
        name = f" {part['name']!r}" if part["name"] else ""
        lines.append((f"part {count}", f"{part['type']}, {part['compression']}{name}"))
        by_type: dict[str, list[str]] = {}
        for channel, pixel_type in part["channels"].items():
            by_type.setdefault(pixel_type, []).append(channel)
        lines += [(f"  {pixel_type}", ", ".join(names)) for pixel_type, names in by_type.items()]
    return lines


def _camera_lines(camera: dict[str, Any]) -> list[Line]:
    """Return the lens values of the header, each with the attribute it comes from."""
    lines = []
    for label, name, unit in _CAMERA_LINES:
        if camera[name] is not None:
            value = f"{_number(camera[name])} {unit}".rstrip()
            lines.append((label, f"{value} ({_source_words(camera['sources'][name])})"))
        elif name in camera["refused"]:
            why = "left out, as no lens has that"
            lines.append((label, f"none (header: {camera['refused'][name]}: {why})"))
    if camera["model"] is None:
        lines = lines or [("camera", "nothing in the header")]
        lines.append(("lens model", f"{LensModel.PHOTOGRAPHIC} (the header names no CG renderer)"))
    return lines


def _source_words(source: str) -> str:
    return source if source.startswith("header, ") else f"header: {source}"


def _primaries_lines(told: dict[str, Any] | None) -> list[Line]:
    """Return the primaries of the colours, and the attribute that states them."""
    if told is None:
        return [("primaries", "linear Rec.709 (the header names no other)")]
    if told["space"] is None:
        said = "unknown to heatlens; taken as the current input space"
        if told["by_matrix"]:
            said = "converted to linear Rec.709 by a matrix for display"
        return [("primaries", f"{told['value']} (header: {told['attribute']}), {said}")]
    return [("primaries", f"{told['space']} (header: {told['attribute']})")]


def _color_lines(color: dict[str, Any]) -> list[Line]:
    """Return layer and range of the colour, or why there is none."""
    lines = []
    if "layer" in color:
        alpha = "with alpha" if color["has_alpha"] else "no alpha"
        view = f" of the view {color['view']}" if color["view"] else ""
        lines.append(("colour", f"{color['layer'] or 'RGB'}{view}, {alpha}"))
        span = "no finite value"
        if color["min"] is not None:
            span = f"{_number(color['min'])} to {_number(color['max'])}"
        bad = f"{color['nan_count']} NaN, {color['infinite_count']} infinite"
        lines.append(("colour range", f"{span}, {bad}"))
    if "problem" in color:
        lines.append(("colour", f"none: {color['problem']}"))
    return lines


def _depth_lines(depth: dict[str, Any]) -> list[Line]:
    """Return channel, convention with its reason and range of the depth, or why there is none."""
    if "problem" in depth:
        return [("depth", f"none: {depth['problem']}")]
    lines = [
        ("depth", f"{depth['channel']}, {depth['convention']}, {depth['kind']}"),
        ("  why", depth["why"]),
    ]
    if "min_px" in depth:
        span = f"{_number(depth['min_px'])} to {_number(depth['max_px'])} px, signed diameter"
        return [*lines, ("  range", span)]
    span = f"{_number(depth['near_m'])} to {_number(depth['far_m'])} m"
    if depth["near_m"] == "infinity":
        span = "none: every pixel is infinitely far"
    counts = f"{depth['infinite_count']} px infinite, {depth['repaired_count']} px repaired"
    return [*lines, ("  range", span), ("  counts", counts)]


def _behind_lines(behind: list[dict[str, Any]]) -> list[Line]:
    """Return what each picture behind adds, or why it cannot be added."""
    return [
        ("behind", f"{one['name']} {one['words']}" + (f": {one['problem']}" * bool(one["problem"])))
        for one in behind
    ]


def _number(value: float | str) -> str:
    """Format a number with five digits; infinity is already a word."""
    return value if isinstance(value, str) else f"{value:.5g}"
