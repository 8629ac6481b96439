"""The options of commands that take a reel or an edit, and the options of each of its shots."""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.reel import SHOT_FIELD, EditOptions, Reel, ReelShot
from heatlens.deliver.export.output import parse_output
from heatlens.fronts.commands.options.given_options import refuse_options
from heatlens.fronts.commands.options.value_types import parse_number, parse_whole_number
from heatlens.fronts.commands.output.say import print_messages
from heatlens.media.documents.reel_file import is_reel, read_reel
from heatlens.media.documents.shot_file import is_shot_file, read_shot
from heatlens.media.sequence.sequence_search import find_sequence

_BLURRED_MESSAGE = "its media are already blurred by a lens of heatlens"
_ONE_SHOT_OPTIONS = ("frames", "part", "plate", "start_timecode")


def add_media_options(parser: argparse.ArgumentParser) -> None:
    """Add the options for reading an edit."""
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
        "--edit-fps", type=parse_number, metavar="N", help="frame rate of an EDL (default 24)"
    )


def add_reel_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of an export of a reel."""
    add_media_options(parser)
    parser.add_argument(
        "--handles",
        type=parse_whole_number,
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


def read_given_reel(args: argparse.Namespace, text: str) -> Reel:
    """Return the reel `text`. Raises InputError if it cannot be read."""
    for folder in args.media:
        if not folder.is_dir():
            raise InputError(f"--media {folder} is not a folder.")
    return read_reel(Path(text), EditOptions(tuple(args.media), args.edit_fps))


def with_blurred_notes(reel: Reel) -> Reel:
    """Return the reel with a note on each shot whose media a lens has blurred already."""
    from heatlens.media.documents.edit_media import is_blurred_source

    shots = (
        replace(shot, notes=(f"{_BLURRED_MESSAGE}: {shot.source}", *shot.notes))
        if is_blurred_source(shot.source)
        else shot
        for shot in reel.shots
    )
    return replace(reel, shots=tuple(shots))


def refuse_blurred(text: str, reel: Reel) -> None:
    """Raise InputError if the edit or reel `text` shows pictures that are already blurred."""
    from heatlens.media.documents.edit_media import is_blurred_source

    blurred = [shot for shot in reel.shots if is_blurred_source(shot.source)]
    if blurred:
        first_blurred = blurred[0]
        others_text = f", and {len(blurred) - 1} more shots" if len(blurred) > 1 else ""
        raise InputError(
            f"{text}: {_BLURRED_MESSAGE} ({first_blurred.source}, of shot "
            f"{first_blurred.name}{others_text}). Give the folder of the pinhole pictures with "
            "--media, not that of an earlier export."
        )


def refuse_reel_options(args: argparse.Namespace) -> None:
    """Raise InputError for options of reels that were given for a single shot."""
    names = ("media", "edit_fps", "handles", "edit_out")
    given_names = [name for name in names if getattr(args, name)]
    if given_names and not is_reel(args.shot):
        refuse_options(args, given_names, f"{args.shot} is neither a reel nor an edit")


def check_for_export(args: argparse.Namespace, reel: Reel) -> None:
    """Raise InputError for options that are about one shot, and for missing media."""
    refuse_options(args, _ONE_SHOT_OPTIONS, "The cut says which frames of its shots are exported")
    refuse_blurred(args.shot, reel)
    if reel.missing_shots:
        missing_texts = "; ".join(
            f"shot {shot.name}: {shot.notes[0]}" for shot in reel.missing_shots
        )
        raise InputError(f"{args.shot}: {missing_texts}. Give their folder with --media.")
    if not parse_output(args.output).is_movie and SHOT_FIELD not in args.output:
        raise InputError(
            f"{args.output} is one name for {len(reel.shots)} shots. Write {SHOT_FIELD} in it, "
            f"such as out/{SHOT_FIELD}/{SHOT_FIELD}.####.exr."
        )


def shots_with_options(
    args: argparse.Namespace, reel: Reel, output: str
) -> Iterator[tuple[ReelShot, argparse.Namespace]]:
    """Yield each shot with the options of its export; `output` has the name of the shot in it."""
    for shot in reel.shots:
        shot_with_handles = with_handles(shot, args.handles)
        values = {
            "shot": shot_with_handles.source,
            "frames": shot_with_handles.exported_frames,
            "fps": _export_rate(args, shot_with_handles, reel),
        }
        if args.burn_in and not args.shot_name:
            values["shot_name"] = shot_with_handles.name
        if (
            args.cdl is None
            and shot_with_handles.grade is not None
            and not parse_output(output).is_exr
        ):
            values["cdl"] = _cdl_option(shot_with_handles)
        values["output"] = output.replace(SHOT_FIELD, shot_with_handles.name)
        yield shot_with_handles, argparse.Namespace(**{**vars(args), **values})


def _cdl_option(shot: ReelShot) -> str | None:
    """Return the grade of the edit as an option; None if the file of the shot has its own."""
    is_own = is_shot_file(shot.source) and read_shot(Path(shot.source)).grade is not None
    return None if is_own else str(shot.grade)


def _export_rate(args: argparse.Namespace, shot: ReelShot, reel: Reel) -> float | None:
    """Return the frame rate to export a shot at; None if its source has its own rate.

    Plates, which may have no rate, get that of the reel unless --fps is given.
    """
    given_rate: float | None = args.fps
    if given_rate is not None or is_shot_file(shot.source) or _frames_on_disk(shot.source) is None:
        return given_rate
    return reel.frames_per_second


def with_handles(shot: ReelShot, handles: int) -> ReelShot:
    """Return the shot with `handles` more frames at both ends, as far as its source has them."""
    if shot.frames is None or not handles:
        return shot
    added_frames = handles * (shot.retime.step if shot.retime else 1)
    wide_frames = FrameRange(shot.frames.first - added_frames, shot.frames.last + added_frames)
    present_frames = _frames_on_disk(shot.source)
    kept_frames = (
        wide_frames
        if present_frames is None
        else wide_frames.intersection(present_frames) or wide_frames
    )
    if kept_frames != wide_frames:
        print_messages(f"{shot.name}: the handles are shorter, as only frames {kept_frames} exist.")
    return replace(shot, frames=kept_frames)


def _frames_on_disk(source: str) -> FrameRange | None:
    """Return the frames that a source has on disk; None for a scene and a still."""
    source_name = read_shot(Path(source)).source if is_shot_file(source) else source
    try:
        sequence = find_sequence(source_name or "")
    except InputError:  # a missing scene, or missing plates, which the plan reports
        return None
    return None if sequence.is_single else FrameRange(sequence.first, sequence.last)
