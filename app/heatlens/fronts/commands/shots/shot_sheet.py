"""`heatlens shot sheet`: write the focus pulls of a shot or a reel, for the first assistant."""

import argparse
import json
from functools import cache
from pathlib import Path
from typing import NamedTuple

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange, parse_frame_range
from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.export.sheet_page import PURPOSE, Sheet, sheet_entries, write_sheet
from heatlens.deliver.export.sheet_rows import sheet_frames
from heatlens.fronts.commands.options.display_options import (
    add_display_options,
    display_look,
    shot_header,
)
from heatlens.fronts.commands.options.given_options import refuse_given
from heatlens.fronts.commands.output.export_progress import failure_reported
from heatlens.fronts.commands.output.progress_line import progress_line
from heatlens.fronts.commands.output.say import say, tell
from heatlens.fronts.commands.shots.following import measured_now
from heatlens.media.documents.reel_file import REEL_SUFFIX, is_reel, read_reel
from heatlens.media.documents.shot_file import SHOT_SUFFIX, is_shot_file, read_shot
from heatlens.media.files.atomic_file import check_writable
from heatlens.media.files.html_page import check_pdf
from heatlens.render.frame_renderer import headless_renderer
from heatlens.render.source.named import source_of

_SUFFIXES = (".html", ".htm", ".pdf")
HELP = "write the pull sheet of a shot or a reel, with a picture of each key"
DESCRIPTION = """\
Writes one page (HTML or PDF with its pictures, for print or a phone) with a row for each focus
key: its picture through the lens, frame, timecode, the mark in focus, the distance in metres and
feet, the depth of field, the stop, and the frames to the next key. A list of all marks with their
distances follows. The same rows are written beside it as CSV. A reel or an edit gives a page for
each of its shot files, with the frames that the cut shows.
"""
EPILOG = """\
examples:
  heatlens shot sheet s.heatlens.json -o pull.html
  heatlens shot sheet s.heatlens.json -o pull.html --start-timecode 10:00:00:00 --title 'Scene 12'
  heatlens shot sheet cut.heatreel.json -o pulls.pdf
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "shot", type=Path, metavar="SHOT.heatlens.json", help="the shot, a reel or an edit"
    )
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="PAGE.html",
        help="page to write, .html or .pdf; a table of the same name, .csv, is written beside it",
    )  # fmt: skip
    parser.add_argument("--title", help="heading of the page (default: the name of the shot)")
    parser.add_argument(
        "--frames", metavar="FIRST-LAST", help="the part of the shot to list (default: in to out)"
    )
    parser.add_argument(
        "--start-timecode",
        metavar="HH:MM:SS:FF",
        help="timecode of the first frame (default: the shot's, else from the plates' headers)",
    )
    parser.add_argument(
        "--progress",
        choices=("terminal", "json"),
        default="terminal",
        help="json: a line on stdout for each picture, and one with a message if it fails",
    )
    add_display_options(parser)


def run(args: argparse.Namespace) -> int:
    """Write the page and the table."""
    with failure_reported(args.progress):
        _write(args)
    return 0


def _write(args: argparse.Namespace) -> None:
    if args.output.suffix.lower() not in _SUFFIXES:
        raise InputError(f"{args.output}: the name of a pull sheet must end in .html or .pdf.")
    check_writable(args.output)
    if args.output.suffix.lower() == ".pdf":
        check_pdf(PURPOSE)
    parts = _parts(args)
    looks = [display_look(args, shot_header(part.shot), part.shot.grade) for part in parts]
    count = sum(len(sheet_frames(part.shot, part.frames)) for part in parts)
    renderer, done, sheets = cache(headless_renderer), 0, []
    with progress_line() as show:
        for part, look in zip(parts, looks, strict=True):
            entries = []
            for entry in sheet_entries(part.shot, part.frames, look, renderer):
                entries.append(entry)
                done += 1
                if args.progress == "json":
                    tell(json.dumps({"event": "frame", "done": done, "frames": count}))
                else:
                    show(f"picture {done} of {count}")
            sheets.append(Sheet(part.title, part.shot, entries))
    table = write_sheet(args.output, args.title or _name(args.shot), sheets)
    if args.progress == "terminal":
        tell(str(args.output))
        tell(str(table))


class _Part(NamedTuple):
    """A shot of the sheet, with the frames to list."""

    title: str
    shot: Shot
    frames: FrameRange


def _parts(args: argparse.Namespace) -> list[_Part]:
    if is_reel(str(args.shot)):
        return _parts_of_reel(args)
    shot = measured_now(_started(args, read_shot(args.shot)))
    return [_Part(args.title or _name(args.shot), shot, _frames_of(args, shot))]


def _parts_of_reel(args: argparse.Namespace) -> list[_Part]:
    """Return the shot files of a reel; others have no keys, which is said."""
    refuse_given(args, ("frames", "start_timecode"), "The cut says which frames are listed")
    reel = read_reel(args.shot)
    parts = []
    for own in reel.shots:
        if not is_shot_file(own.source):
            say(f"{own.name}: {own.source or 'its media'} is not a shot file, so it has no pull.")
            continue
        shot = measured_now(read_shot(own.source))
        parts.append(_Part(own.name, shot, own.frames or _frames_of(args, shot)))
    if not parts:
        raise InputError(f"{args.shot} has no shot file: `heatlens reel` makes one for each clip.")
    return parts


def _name(path: Path) -> str:
    return path.name.removesuffix(SHOT_SUFFIX).removesuffix(REEL_SUFFIX)


def _started(args: argparse.Namespace, shot: Shot) -> Shot:
    return shot if args.start_timecode is None else shot.started_at(args.start_timecode)


def _frames_of(args: argparse.Namespace, shot: Shot) -> FrameRange:
    """Return the frames to list: the given ones, else those from in to out, else all."""
    if args.frames:
        return parse_frame_range(args.frames)
    frames = source_of(shot).frames_of(shot)
    return shot.played or FrameRange(min(frames), max(frames))
