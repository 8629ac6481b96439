"""The options of commands that take a reel or an edit, and the options of each of its shots."""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.reel import SHOT_FIELD, Reel, ReelShot
from heatlens.deliver.export.output import parse_output
from heatlens.fronts.commands.options.given_options import refuse_given
from heatlens.fronts.commands.options.value_types import number, whole
from heatlens.fronts.commands.output.say import say
from heatlens.media.documents.edit_file import EditOptions
from heatlens.media.documents.edit_media import is_blurred_source
from heatlens.media.documents.reel_file import is_reel, read_reel
from heatlens.media.documents.shot_file import is_shot_file, read_shot
from heatlens.media.sequence.sequence import find_sequence

_BLURRED = "its media are already blurred by a lens of heatlens"
_ONE_SHOT = ("frames", "part", "plate", "start_timecode")


def add_media_options(parser: argparse.ArgumentParser) -> None:
    """Add how an edit is read."""
    group = parser.add_argument_group("reels and edits")
    group.add_argument(
        "--media",
        type=Path,
        action="append",
        default=[],
        metavar="FOLDER",
        help="look here for media that are not where the edit says; may be given several times",
    )
    group.add_argument(
        "--edit-fps", type=number, metavar="N", help="frame rate of an EDL (default 24)"
    )


def add_reel_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of an export of a reel."""
    add_media_options(parser)
    parser.add_argument(
        "--handles",
        type=whole,
        default=0,
        metavar="N",
        help="frames before and after the part of each shot that the cut shows (default 0)",
    )
    parser.add_argument(
        "--edit-out",
        type=Path,
        metavar="FILE.otio",
        help="write the cut with the exported frames in place of the plates, and the focus keys "
        "as markers",
    )


def reel_of(args: argparse.Namespace, text: str) -> Reel:
    """Return the reel `text`. Raises InputError if it cannot be read."""
    for folder in args.media:
        if not folder.is_dir():
            raise InputError(f"--media {folder} is not a folder.")
    return read_reel(Path(text), EditOptions(tuple(args.media), args.edit_fps))


def with_blurred_notes(reel: Reel) -> Reel:
    """Return the reel with a note on each shot whose media a lens has blurred already."""
    shots = (
        replace(shot, notes=(f"{_BLURRED}: {shot.source}", *shot.notes))
        if is_blurred_source(shot.source)
        else shot
        for shot in reel.shots
    )
    return replace(reel, shots=tuple(shots))


def refuse_blurred(text: str, reel: Reel) -> None:
    """Raise InputError if the edit or reel `text` shows what a lens has blurred already."""
    blurred = [shot for shot in reel.shots if is_blurred_source(shot.source)]
    if blurred:
        first = blurred[0]
        more = f", and {len(blurred) - 1} more shots" if len(blurred) > 1 else ""
        raise InputError(
            f"{text}: {first.name}{more}: {_BLURRED}: {first.source}. Give the folder of the "
            "pinhole pictures with --media, and none of a former export."
        )


def refuse_reel_options(args: argparse.Namespace) -> None:
    """Raise InputError for options of reels that were given for a single shot."""
    names = ("media", "edit_fps", "handles", "edit_out")
    given = [name for name in names if getattr(args, name)]
    if given and not is_reel(args.shot):
        refuse_given(args, given, f"{args.shot} is neither a reel nor an edit")


def checked_for_export(args: argparse.Namespace, reel: Reel) -> None:
    """Raise InputError for options that are about one shot, and for missing media."""
    refuse_given(args, _ONE_SHOT, "The cut says which frames of its shots are exported")
    refuse_blurred(args.shot, reel)
    if reel.missing:
        named = "; ".join(f"{shot.name}: {shot.notes[0]}" for shot in reel.missing)
        raise InputError(f"{args.shot}: {named}. Give their folder with --media.")
    if not parse_output(args.output).is_movie and SHOT_FIELD not in args.output:
        raise InputError(
            f"{args.output} is one name for {len(reel.shots)} shots. Write {SHOT_FIELD} in it, "
            f"such as out/{SHOT_FIELD}/{SHOT_FIELD}.####.exr."
        )


def shots_of(
    args: argparse.Namespace, reel: Reel, output: str
) -> Iterator[tuple[ReelShot, argparse.Namespace]]:
    """Yield each shot with the options of its export; `output` has the name of the shot in it."""
    for shot in reel.shots:
        own = with_handles(shot, args.handles)
        values = {"shot": own.source, "frames": own.made, "fps": _rate(args, own, reel)}
        if args.burn_in and not args.shot_name:
            values["shot_name"] = own.name
        if args.cdl is None and own.grade is not None and not parse_output(output).is_exr:
            values["cdl"] = _cdl(own)
        values["output"] = output.replace(SHOT_FIELD, own.name)
        yield own, argparse.Namespace(**{**vars(args), **values})


def _cdl(shot: ReelShot) -> str | None:
    """Return the grade of the edit as an option; None if the file of the shot has its own."""
    is_own = is_shot_file(shot.source) and read_shot(Path(shot.source)).grade is not None
    return None if is_own else str(shot.grade)


def _rate(args: argparse.Namespace, shot: ReelShot, reel: Reel) -> float | None:
    """Return the rate to export plates at, which do not always tell one; others have their own."""
    given: float | None = args.fps
    if given is not None or is_shot_file(shot.source) or _frames_there(shot.source) is None:
        return given
    return reel.frames_per_second


def with_handles(shot: ReelShot, handles: int) -> ReelShot:
    """Return the shot with `handles` more frames at both ends, as far as its source has them."""
    if shot.frames is None or not handles:
        return shot
    more = handles * (shot.retime.step if shot.retime else 1)
    wide = FrameRange(shot.frames.first - more, shot.frames.last + more)
    there = _frames_there(shot.source)
    kept = wide if there is None else wide.intersection(there) or wide
    if kept != wide:
        say(f"{shot.name}: there are no handles but those of frames {kept}.")
    return replace(shot, frames=kept)


def _frames_there(source: str) -> FrameRange | None:
    """Return the frames that a source has on disk; None for a scene and a still."""
    named = read_shot(Path(source)).source if is_shot_file(source) else source
    try:
        sequence = find_sequence(named or "")
    except InputError:  # a missing scene, or missing plates, which the plan tells
        return None
    return None if sequence.is_single else FrameRange(sequence.first, sequence.last)
