"""`heatlens shot sheet`: write the focus pulls of a shot or a reel, for the first assistant."""

import argparse
import json
from functools import cache
from pathlib import Path
from typing import NamedTuple

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange, parse_frame_range
from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.export.sheet_rows import sheet_frames
from heatlens.fronts.commands.options.display_options import (
    add_display_options,
    display_settings,
    shot_header,
)
from heatlens.fronts.commands.options.given_options import refuse_options
from heatlens.fronts.commands.output.export_progress import report_failure
from heatlens.fronts.commands.output.progress_line import progress_line
from heatlens.fronts.commands.output.say import print_messages, print_result
from heatlens.fronts.commands.shots.following import measure_live_focus
from heatlens.media.documents.reel_file import REEL_SUFFIX, is_reel, read_reel
from heatlens.media.documents.shot_file import SHOT_SUFFIX, is_shot_file, read_shot
from heatlens.media.files.atomic_file import check_writable
from heatlens.media.files.html_page import check_pdf
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
    with report_failure(args.progress):
        _write_sheet(args)
    return 0


def _write_sheet(args: argparse.Namespace) -> None:
    """Render the pictures of all rows, and write the page and the table. Raises InputError."""
    # Imported here because `shot show` and `shot new`, which are often used, draw nothing.
    from heatlens.deliver.export.sheet_page import PURPOSE, Sheet, sheet_entries, write_sheet
    from heatlens.render.frame_renderer import headless_renderer

    if args.output.suffix.lower() not in _SUFFIXES:
        raise InputError(f"{args.output}: the name of a pull sheet must end in .html or .pdf.")
    check_writable(args.output)
    if args.output.suffix.lower() == ".pdf":
        check_pdf(PURPOSE)
    parts = _sheet_parts(args)
    looks = [display_settings(args, shot_header(part.shot), part.shot.grade) for part in parts]
    count = sum(len(sheet_frames(part.shot, part.frames)) for part in parts)
    renderer, done_count, sheets = cache(headless_renderer), 0, []
    with progress_line() as show_progress:
        for part, look in zip(parts, looks, strict=True):
            entries = []
            for entry in sheet_entries(part.shot, part.frames, look, renderer):
                entries.append(entry)
                done_count += 1
                if args.progress == "json":
                    print_result(
                        json.dumps({"event": "frame", "done": done_count, "frames": count})
                    )
                else:
                    show_progress(f"picture {done_count} of {count}")
            sheets.append(Sheet(part.title, part.shot, entries))
    table = write_sheet(args.output, args.title or _document_name(args.shot), sheets)
    if args.progress == "terminal":
        print_result(str(args.output))
        print_result(str(table))


class _SheetPart(NamedTuple):
    """A shot of the sheet, with the frames to list."""

    title: str
    shot: Shot
    frames: FrameRange


def _sheet_parts(args: argparse.Namespace) -> list[_SheetPart]:
    """Return the shots to list: the one of a shot file, or those of a reel."""
    if is_reel(str(args.shot)):
        return _parts_of_reel(args)
    shot = measure_live_focus(_with_start_timecode(args, read_shot(args.shot)))
    return [_SheetPart(args.title or _document_name(args.shot), shot, _frames_to_list(args, shot))]


def _parts_of_reel(args: argparse.Namespace) -> list[_SheetPart]:
    """Return the shots of a reel that have a shot file; print which ones have none."""
    refuse_options(args, ("frames", "start_timecode"), "The cut says which frames are listed")
    reel = read_reel(args.shot)
    parts = []
    for reel_shot in reel.shots:
        if not is_shot_file(reel_shot.source):
            print_messages(
                f"{reel_shot.name}: {reel_shot.source or 'its media'} is not a shot file, so it "
                "has no pull. `heatlens reel CUT -o REEL --shots FOLDER` makes shot files."
            )
            continue
        shot = measure_live_focus(read_shot(reel_shot.source))
        parts.append(
            _SheetPart(reel_shot.name, shot, reel_shot.frames or _frames_to_list(args, shot))
        )
    if not parts:
        raise InputError(f"{args.shot} has no shot file: `heatlens reel` makes one for each clip.")
    return parts


def _document_name(path: Path) -> str:
    return path.name.removesuffix(SHOT_SUFFIX).removesuffix(REEL_SUFFIX)


def _with_start_timecode(args: argparse.Namespace, shot: Shot) -> Shot:
    return shot if args.start_timecode is None else shot.with_start_timecode(args.start_timecode)


def _frames_to_list(args: argparse.Namespace, shot: Shot) -> FrameRange:
    """Return the frames to list: the given ones, else those from in to out, else all."""
    if args.frames:
        return parse_frame_range(args.frames)
    frames = source_of(shot).frames_of(shot)
    return shot.played_frames or FrameRange(min(frames), max(frames))
