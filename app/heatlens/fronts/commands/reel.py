"""`heatlens reel`: make a reel of shots, from an edit or from files, and follow a changed edit."""

import argparse
from dataclasses import replace
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.reel import Reel, ReelShot
from heatlens.fronts.commands.options.field_options import given_fields
from heatlens.fronts.commands.options.reel_options import (
    add_media_options,
    read_given_reel,
    refuse_blurred,
)
from heatlens.fronts.commands.output.say import gather_messages, print_messages, print_result
from heatlens.fronts.commands.shots.shot_new import add_shot_options, make_shot
from heatlens.media.documents.reel_file import REEL_SUFFIX, is_reel, write_reel
from heatlens.media.documents.shot_file import SHOT_SUFFIX, is_shot_file, read_shot, write_shot
from heatlens.media.files.atomic_file import make_folder
from heatlens.render.source.reel_shots import reel_shots

DESCRIPTION = """\
Makes a reel, a small file with the names of shots in order, from an edit (.otio, .edl, .xml, .aaf)
or from shot files, plates and scenes. With --shots, each clip gets a shot file with the lens of the
options and of the plates' headers.

Do it again after the edit has changed: shot files that are there keep their lens, keys and marks,
and only their part from in to out follows the cut.
"""
EPILOG = """\
examples:
  heatlens reel cut.otio -o cut.heatreel.json --shots shots --f-stop 2 --focus-distance 2.4
  heatlens reel cut.edl -o cut.heatreel.json --media /show/plates --edit-fps 25
  heatlens reel sh010.heatlens.json sh020.heatlens.json -o evening.heatreel.json
  heatlens export cut.heatreel.json -o 'out/{shot}/{shot}.####.exr'
"""


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("sources", nargs="+", metavar="EDIT", help="an edit; or shots in order")
    parser.add_argument("-o", "--output", type=Path, required=True, help=f"*{REEL_SUFFIX} to write")
    parser.add_argument(
        "--shots", type=Path, metavar="FOLDER", help="write a shot file for each clip into it"
    )
    add_media_options(parser)
    add_shot_options(parser)


def run(args: argparse.Namespace) -> int:
    """Write the reel and its shots; print what the edit holds that a reel cannot."""
    if not args.output.name.lower().endswith(REEL_SUFFIX):
        raise InputError(f"{args.output}: the name of a reel must end in {REEL_SUFFIX}.")
    reel = _make_reel(args)
    print_messages(*(f"{shot.name}: {note}." for shot in reel.shots for note in shot.notes))
    if args.shots is not None:
        make_folder(args.shots)
        with gather_messages(len(reel.shots)):
            reel = replace(reel, shots=tuple(_write_shot_file(args, shot) for shot in reel.shots))
    write_reel(args.output, reel)
    print_result(str(args.output))
    return 0


def _make_reel(args: argparse.Namespace) -> Reel:
    """Return the reel of the one edit, or of the shots that were named."""
    first_source, *other_sources = args.sources
    if is_reel(first_source) and not other_sources:
        reel = read_given_reel(args, first_source)
        refuse_blurred(first_source, reel)
        return reel
    return Reel(args.output.name[: -len(REEL_SUFFIX)], reel_shots(args.sources))


def _write_shot_file(args: argparse.Namespace, shot: ReelShot) -> ReelShot:
    """Return the shot with its shot file as source, which is written or follows the cut."""
    if not shot.source or is_shot_file(shot.source):
        return shot
    path = args.shots / f"{shot.name}{SHOT_SUFFIX}"
    if path.exists():
        _update_shot_file(path, shot)
        if given_fields(args, Lens):
            print_messages(f"{shot.name}: {path} was there, and keeps its own lens.")
    else:
        shot_args = argparse.Namespace(
            **{**vars(args), "plate": shot.source, "mark": [*args.mark, *shot.marks]}
        )
        write_shot(path, replace(make_shot(shot_args), in_out=shot.frames, grade=shot.grade))
    return replace(shot, source=str(path.absolute()))


def _update_shot_file(path: Path, shot: ReelShot) -> None:
    """Set source, part and grade of a shot file from the cut; everything else in it stays."""
    old_shot = read_shot(path)
    new_shot_in_file = replace(old_shot, source=shot.source, in_out=shot.frames, grade=shot.grade)
    if new_shot_in_file == old_shot:
        return
    write_shot(path, new_shot_in_file)
    print_messages(
        f"{shot.name}: the cut shows frames {_frames_as_text(shot.frames)}, before "
        f"{_frames_as_text(old_shot.in_out)}."
    )


def _frames_as_text(frames: FrameRange | None) -> str:
    """Return a frame range as text; "all" for None."""
    return "all" if frames is None else str(frames)
