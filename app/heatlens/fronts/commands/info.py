"""`heatlens info`: print what is in a file and how heatlens would read it."""

import argparse
import json
import os
from collections.abc import Sequence as Items
from itertools import count
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.outside_text import printable
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.reel import Reel, ReelShot
from heatlens.core.model.units import format_distance
from heatlens.fronts.commands.options.lens_options import add_plate_options, plate_options
from heatlens.fronts.commands.options.reel_options import (
    add_media_options,
    read_given_reel,
    with_blurred_notes,
)
from heatlens.fronts.commands.options.scene_options import add_placing_options
from heatlens.fronts.commands.options.value_types import parse_number
from heatlens.fronts.commands.output.progress_line import progress_line
from heatlens.fronts.commands.output.say import print_result
from heatlens.fronts.commands.output.thing_words import thing_lines
from heatlens.fronts.commands.sources.source_commands import Facts, Line, commands_for
from heatlens.media.documents.reel_file import is_reel
from heatlens.media.documents.shot_file import is_shot_file
from heatlens.media.files.json_record import record_to_json
from heatlens.media.sequence.names import NameForm, parse_frame_name, parse_pattern
from heatlens.media.sequence.sequence import Sequence
from heatlens.media.sequence.sequence_search import find_sequence

DESCRIPTION = """\
Prints what a render holds and how heatlens would read it: size and windows (pixels), channels, the
lens in the header (focal length and sensor in mm, focus in metres), the primaries of the colours,
the range of the depth (metres), and how the depth is interpreted and why. Try the depth options
here before a render.

For several frames (shot.####.exr, a folder, or a list of files): which frames exist and which are
missing, their sizes, how their depth is read, and its range over the shot.

For a 3D scene: its cameras, frames, objects, triangles, lights and size.

For a reel or an edit (.otio, .edl, .xml, .aaf): its shots with their media and frames, and what a
reel cannot hold, such as a change of speed.

The exit code is 1 if frames of a sequence are missing, or cannot be rendered because they are
damaged or have no depth, so that a farm can check plates before it renders. A single file that can
be read gives 0, also without depth.

--json writes lengths in metres and millimetres as the names say. A window is [x0, y0, x1, y1] with
x1 and y1 behind the last pixel: [0, 0, 320, 180] has 320 x 180 pixels. The text names the last
pixel, (319, 179), as the EXR header does. width_px and height_px are the size of the data window,
display_width_px and display_height_px that of the display window.
"""

_LABEL_WIDTH = 16


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "plates",
        nargs="+",
        metavar="PLATE",
        help="one or more renders; a sequence; a folder; a 3D scene; a reel or an edit; or demo",
    )
    parser.add_argument("--json", action="store_true", help="print JSON for programs; see above")
    add_plate_options(parser)
    lens = parser.add_argument_group("lens", "For --depth-kind radial, if the header has none.")
    lens.add_argument("--focal-length", type=parse_number, metavar="MM", help="focal length in mm")
    lens.add_argument(
        "--sensor-width", type=parse_number, metavar="MM", help="width of the sensor in mm"
    )
    add_media_options(parser)
    add_placing_options(parser.add_argument_group("3D scene", "For a file that does not say it."))


def run(args: argparse.Namespace) -> int:
    """Print the facts; the exit code is 1 if frames of a sequence are missing or damaged."""
    descriptions = [_describe_item(args, item) for item in group_files(args.plates)]
    if args.json:
        facts = [item[0] for item in descriptions]
        print_result(
            json.dumps(facts if len(facts) > 1 else facts[0], indent=2, allow_nan=False), "\n"
        )
    else:
        print_result("\n\n".join(_aligned_text(lines) for _, lines in descriptions), "\n")
    return int(any(lacks_frames(facts) for facts, _ in descriptions))


def _describe_item(args: argparse.Namespace, item: str | Sequence) -> tuple[Facts, list[Line]]:
    """Return the facts of a file, a sequence or a reel for programs, and as lines for people."""
    if isinstance(item, Sequence):
        return sequence_info(item, plate_options(args))
    if is_shot_file(item):
        raise InputError(f"{item} is a shot file: `heatlens shot show {item}` prints it.")
    if is_reel(item):
        return reel_info(with_blurred_notes(read_given_reel(args, item)))
    return commands_for(item).info(args, item)


def _aligned_text(lines: list[Line]) -> str:
    """Return the lines as text with aligned labels."""
    return "\n".join(f"{label:<{_LABEL_WIDTH}}{printable(str(value))}" for label, value in lines)


def group_files(texts: Items[str]) -> list[str | Sequence]:
    """Return a file or a sequence for the names; listed frames of one shot become one sequence.

    Patterns and folders are sequences. Listed files belong together if their names have the same
    form. Raises InputError for a pattern without files.
    """
    groups: dict[tuple[Path, NameForm], list[int]] = {}
    items: list[str | Sequence | tuple[Path, NameForm]] = []
    for text in texts:
        path = Path(os.path.expanduser(text))
        is_pattern = not path.exists() and parse_pattern(path.name) is not None
        form, frame = parse_frame_name(path.name)
        if path.is_dir() or is_pattern:
            items.append(find_sequence(text))
        elif frame is None or len(texts) == 1 or not path.exists():
            items.append(text)
        else:
            key = (path.parent, form)
            if key not in groups:
                items.append(key)
            groups.setdefault(key, []).append(frame)
    return [
        _sequence_of_frames(item, groups) if isinstance(item, tuple) else item for item in items
    ]


def _sequence_of_frames(
    key: tuple[Path, NameForm], groups: dict[tuple[Path, NameForm], list[int]]
) -> str | Sequence:
    """Return the name of a single file, or the sequence of the listed frames."""
    folder, form = key
    frames = tuple(sorted(groups[key]))
    if len(frames) == 1:
        return str(folder / form.name_at(frames[0]))
    all_frames = tuple(range(frames[0], frames[-1] + 1))
    return Sequence(folder, form, all_frames, frames)


def sequence_info(sequence: Sequence, options: PlateOptions) -> tuple[Facts, list[Line]]:
    """Return the facts of a sequence, and lines of text; show the progress on a terminal."""
    from heatlens.media.frame_cache.sequence_facts import sequence_facts

    number = count(1)
    with progress_line() as show:
        facts = sequence_facts(
            sequence,
            options,
            lambda frame: show(f"frame {frame}, {next(number)} of {len(sequence.present)}"),
        )
    return facts, _sequence_lines(facts)


def lacks_frames(facts: Facts) -> bool:
    """Return True for a sequence of which frames are missing or damaged, and for missing media."""
    return bool(facts.get("missing") or facts.get("damaged"))


def _sequence_lines(facts: Facts) -> list[Line]:
    """Return the facts of a sequence as lines of text."""
    lines = [
        ("sequence", facts["path"]),
        ("frames", f"{facts['frames']} ({facts['frame_count']})"),
        ("missing", facts["missing"] or "none"),
        *_lines_by_frames("size", facts["sizes"]),
        *_lines_by_frames("depth", facts["depth"]),
    ]
    if facts["near_m"] is not None:
        near_text, far_text = format_distance(facts["near_m"]), format_distance(facts["far_m"])
        range_text = (
            f"{near_text} (frame {facts['near_frame']}) to {far_text} (frame {facts['far_frame']})"
        )
        lines.append(("  range", range_text))
    lines += thing_lines(facts["things"])
    lines += [("behind", f"{name} {words}") for name, words in facts["behind"].items()]
    neighbours = facts["neighbours"]
    if neighbours["count"]:
        lines.append(("neighbours", neighbours["words"]))
        lines.append(("  found", f"{neighbours['found']:.0%} of what is hidden behind edges"))
    lines += _lines_by_frames("note", facts["notes"])
    lines += [(f"frame {frame}", sentence) for frame, sentence in facts["damaged"].items()]
    return lines


def _lines_by_frames(label: str, frames_of: dict[str, str]) -> list[Line]:
    """Return one line if all frames agree, else a line for each value with its frames."""
    if len(frames_of) == 1 and label != "note":
        return [(label, name) for name in frames_of]
    return [(label, f"{name} ({_frames_text(frames)})") for name, frames in frames_of.items()]


def _frames_text(frames: str) -> str:
    """Return "frame 2" or "frames 1-2,5"."""
    return f"frame {frames}" if frames.isdecimal() else f"frames {frames}"


def reel_info(reel: Reel) -> tuple[Facts, list[Line]]:
    """Return the facts of a reel for programs, and as lines for people."""
    facts = {
        "reel": reel.name,
        "frames_per_second": reel.frames_per_second,
        "start_timecode": reel.start_timecode,
        "shots": [record_to_json(shot) for shot in reel.shots],
        "missing": [shot.name for shot in reel.missing_shots],
    }
    start_text = f", from {reel.start_timecode}" if reel.start_timecode else ""
    count_text = "1 shot" if len(reel.shots) == 1 else f"{len(reel.shots)} shots"
    cut_text = f"{count_text}, {reel.frames_per_second:g} frames a second{start_text}"
    lines = [("reel", reel.name), ("cut", cut_text)]
    for shot in reel.shots:
        lines += _reel_lines(shot)
    return facts, lines


def _reel_lines(shot: ReelShot) -> list[Line]:
    """Return the lines for one shot of a reel: source and frames, marks, grade and notes."""
    frames = "all frames"
    if shot.frames is not None:
        frames = f"{shot.frames} ({shot.frames.count})"
    source_line = f"{shot.source}, {frames}" if shot.source else f"no media, {frames}"
    grade = [] if shot.grade is None else [("  grade", str(shot.grade))]
    marks = [("  mark", mark) for mark in shot.marks]
    return [(shot.name, source_line), *marks, *grade, *(("  note", note) for note in shot.notes)]
