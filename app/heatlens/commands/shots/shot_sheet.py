"""`heatlens shot sheet`: write the focus pull of a shot on one page, for the first assistant."""

import argparse
import json
from pathlib import Path

from heatlens.base.errors import InputError
from heatlens.commands.options.display_options import (
    add_display_options,
    display_look,
    shot_header,
)
from heatlens.commands.output.export_progress import failure_reported
from heatlens.commands.output.progress_line import progress_line
from heatlens.commands.output.say import tell
from heatlens.documents.shot_file import SHOT_SUFFIX, read_shot
from heatlens.export.sheet.page import PURPOSE, sheet_entries, write_sheet
from heatlens.export.sheet.rows import sheet_frames
from heatlens.files.html_page import check_pages
from heatlens.files.output_check import check_writable
from heatlens.model.frames import FrameRange, parse_frame_range
from heatlens.model.shot import Shot
from heatlens.render import headless_renderer
from heatlens.source.named import source_of

_SUFFIXES = (".html", ".htm")
HELP = "write the pull sheet of a shot, with a picture of each key"
DESCRIPTION = """\
Writes one page (HTML with its pictures, for print or a phone) with a row for each focus key: its
picture through the lens, frame, timecode, the mark in focus, the distance in metres and feet, the
depth of field, the stop, and the frames to the next key. A list of all marks with their distances
follows. The same rows are written beside it as CSV.
"""
EPILOG = """\
examples:
  heatlens shot sheet s.heatlens.json -o pull.html
  heatlens shot sheet s.heatlens.json -o pull.html --start-timecode 10:00:00:00 --title 'Scene 12'
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("shot", type=Path, metavar="SHOT.heatlens.json", help="the shot")
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="PAGE.html",
        help="page to write; a table of the same name, .csv, is written beside it",
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
        raise InputError(f"{args.output}: the name of a pull sheet must end in .html.")
    check_writable(args.output)
    check_pages(PURPOSE)
    shot = _shot_of(args)
    frames = _frames_of(args, shot)
    look, count = display_look(args, shot_header(shot)), len(sheet_frames(shot, frames))
    entries = []
    with progress_line() as show:
        for entry in sheet_entries(shot, frames, look, headless_renderer):
            entries.append(entry)
            if args.progress == "json":
                tell(json.dumps({"event": "frame", "done": len(entries), "frames": count}))
            else:
                show(f"picture {len(entries)} of {count}")
    title = args.title or args.shot.name.removesuffix(SHOT_SUFFIX)
    table = write_sheet(args.output, title, shot, entries)
    if args.progress == "terminal":
        tell(str(args.output))
        tell(str(table))


def _shot_of(args: argparse.Namespace) -> Shot:
    shot = read_shot(args.shot)
    if args.start_timecode is None:
        return shot
    return shot.started_at(args.start_timecode)


def _frames_of(args: argparse.Namespace, shot: Shot) -> FrameRange:
    """Return the frames to list: the given ones, else those from in to out, else all."""
    if args.frames:
        return parse_frame_range(args.frames)
    frames = source_of(shot).frames_of(shot)
    return shot.played or FrameRange(min(frames), max(frames))
