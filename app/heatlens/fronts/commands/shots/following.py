"""The options of `heatlens shot new` that let the focus follow a mark."""

import argparse
import re
from dataclasses import replace

from heatlens.core.base.errors import InputError
from heatlens.core.model.focus.live_focus import Follow, LiveFocus, Pursuit
from heatlens.core.model.marks.marks import MatteMark
from heatlens.core.model.marks.track_mark import TrackMark
from heatlens.core.model.shot.pull import bake_live_focus
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.options.field_options import add_fields, given_fields
from heatlens.fronts.commands.output.progress_line import progress_line
from heatlens.fronts.commands.output.say import print_messages
from heatlens.fronts.commands.sources.source_commands import commands_for
from heatlens.media.sequence.names import frames_text
from heatlens.render.source.live_focus import measure_followed_marks

_PULL = re.compile(r"([^@]+)@(-?\d{1,9})\+(\d{1,6})")


def add_follow_options(parser: argparse.ArgumentParser) -> None:
    """Add the group `focus that follows`."""
    group = parser.add_argument_group(
        "focus that follows", "The focus is measured on the plates, and reduced to few keys."
    )
    group.add_argument(
        "--follow",
        metavar="NAME[=WHAT]",
        help="let the focus follow a mark at every frame: one of --mark, or a new one, such as "
        "A=cryptomatte:hero; --focus-distance is not needed then",
    )
    group.add_argument(
        "--follow-pull",
        action="append",
        default=[],
        metavar="NAME@FRAME+FRAMES",
        help="leave the followed mark at a frame for another one, made with --mark, and arrive so "
        "many frames later: B@1040+18; may be repeated",
    )
    group.add_argument(
        "--live",
        action="store_true",
        help="keep the following itself in the shot, in place of keys: what is made of the shot is "
        "measured again where the plates have changed",
    )
    add_fields(group, Follow)


def followed_mark_name(args: argparse.Namespace) -> str | None:
    """Return the name of the mark that the focus follows; None without --follow.

    Raises InputError where something else sets the focus, and for options without --follow.
    """
    if args.follow is None:
        if given_fields(args, Follow) or args.follow_pull or args.live:
            raise InputError(
                "--live and --follow-... need --follow, which names the mark to follow."
            )
        return None
    if any(text.startswith("focus@") for text in args.key):
        raise InputError("--follow sets the focus at every frame: leave --key focus@... out.")
    return str(args.follow).partition("=")[0].partition("@")[0]


def track_marks(args: argparse.Namespace, shot: Shot) -> Shot:
    """Return the shot with its tracked surfaces followed; print the frames that are in doubt.

    Raises InputError where they cannot be followed, and for a thing that no frame has.
    """
    for mark in shot.marks:
        if isinstance(mark, MatteMark):
            commands_for(args.plate).check_thing(args, mark)
    marks = [
        commands_for(args.plate).track_mark(args, shot, mark)
        if isinstance(mark, TrackMark)
        else mark
        for mark in shot.marks
    ]
    for mark in marks:
        if isinstance(mark, TrackMark) and (frames := mark.doubtful_frames):
            print_messages(
                f"{mark.name} looks different at frames {frames_text(frames)}: look there, and "
                "correct it with one more X,Y@FRAME if it is wrong."
            )
    return replace(shot, marks=tuple(marks))


def make_focus_follow(args: argparse.Namespace, shot: Shot, name: str) -> Shot:
    """Return the shot with a focus that follows its mark; print where the mark is hidden.

    Raises InputError if the shot has no such mark or no plates, or if the mark cannot be measured
    on them.
    """
    pursuits = (Pursuit(name), *map(_parse_pursuit, args.follow_pull))
    for pursuit in pursuits:
        if not any(mark.name == pursuit.mark for mark in shot.marks):
            raise InputError(
                f"--follow {pursuit.mark}: there is no such mark. Add --mark {pursuit.mark}=WHAT."
            )
    live = LiveFocus(pursuits, Follow(**given_fields(args, Follow)))
    keyless = replace(shot.curves.focus_distance_m, keys=())
    curves = replace(shot.curves, focus_distance_m=keyless, live=live)
    with progress_line() as show:
        measured_shot = measure_followed_marks(replace(shot, curves=curves), show)
    assert measured_shot.curves.live is not None
    _print_hidden_frames(measured_shot.curves.live)
    frames_text_of_focus = _count_text(len(measured_shot.curves.live.frames), "frame")
    message = f"the focus follows {live.words} over {frames_text_of_focus}"
    if args.live:
        print_messages(f"{message}, live.")
    else:
        measured_shot = bake_live_focus(measured_shot)
        print_messages(
            f"{message} with {_count_text(len(measured_shot.curves.focus_distance_m.keys), 'key')}."
        )
    first = measured_shot.frames.first if measured_shot.frames else 1
    return replace(
        measured_shot, lens=replace(shot.lens, focus_distance_m=_focus_m(measured_shot, first))
    )


def measure_live_focus(shot: Shot) -> Shot:
    """Return the shot with its live focus measured again, if its files have changed; print that.

    Raises InputError as `measured` does.
    """
    with progress_line() as show:
        measured_shot = measure_followed_marks(shot, show)
    live = shot.curves.live
    if measured_shot != shot and live is not None and live.measured:
        print_messages(
            f"what {live.words} is on has changed since it was measured: the focus is new."
        )
    return measured_shot


def _focus_m(shot: Shot, frame: int) -> float:
    return shot.lens_at(frame).focus_distance_m


def _count_text(count: int, noun: str) -> str:
    return f"1 {noun}" if count == 1 else f"{count} {noun}s"


def _print_hidden_frames(live: LiveFocus) -> None:
    """Print the frames at which each followed mark is hidden or out of the picture."""
    for track in live.measured:
        places = zip(live.frames, track.distances_m, strict=True)
        hidden = [frame for frame, distance_m in places if distance_m is None]
        if hidden:
            print_messages(
                f"{track.mark} is hidden, or out of the picture, at frames {frames_text(hidden)}: "
                "there the focus moves on to where it is seen again."
            )


def _parse_pursuit(text: str) -> Pursuit:
    """Parse "B@1040+18". Raises InputError for anything else."""
    match = _PULL.fullmatch(text)
    if match is None:
        raise InputError(f"--follow-pull {text}: write a mark, a frame and a length: B@1040+18.")
    return Pursuit(mark=match[1], start_frame=int(match[2]), frames=int(match[3]))
