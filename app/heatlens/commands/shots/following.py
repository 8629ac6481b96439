"""The options of `heatlens shot new` that let the focus follow a mark."""

import argparse
from dataclasses import replace

from heatlens.base.errors import InputError
from heatlens.commands.options.field_options import add_fields, typed_fields
from heatlens.commands.output.say import say
from heatlens.commands.sources.source_commands import commands_for
from heatlens.model.following import Follow, followed
from heatlens.model.lens import Lens
from heatlens.model.marks import TrackMark
from heatlens.model.shot import LensParameter, Shot
from heatlens.sequence.names import frames_text


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
    add_fields(group, Follow)


def followed_name(args: argparse.Namespace) -> str | None:
    """Return the name of the mark that the focus follows; None without --follow.

    Raises InputError where something else sets the focus, and for options without --follow.
    """
    if args.follow is None:
        if typed_fields(args, Follow):
            raise InputError("--follow-... options need --follow, which names the mark to follow.")
        return None
    if any(text.startswith("focus@") for text in args.key):
        raise InputError("--follow sets the focus at every frame: leave --key focus@... out.")
    return str(args.follow).partition("=")[0].partition("@")[0]


def shot_with_tracks(args: argparse.Namespace, shot: Shot) -> Shot:
    """Return the shot with its tracked surfaces followed; say where they are in doubt.

    Raises InputError where they cannot be followed.
    """
    marks = [
        commands_for(args.plate).tracked(args, shot, mark) if isinstance(mark, TrackMark) else mark
        for mark in shot.marks
    ]
    for mark in marks:
        if isinstance(mark, TrackMark) and (frames := mark.doubted):
            say(
                f"{mark.name} looks different at frames {frames_text(frames)}: look there, and "
                "correct it with one more X,Y@FRAME if it is wrong."
            )
    return replace(shot, marks=tuple(marks))


def shot_that_follows(args: argparse.Namespace, shot: Shot, name: str) -> Shot:
    """Return the shot with a focus that follows its mark; say where the mark is hidden.

    Raises InputError where the shot has no such mark or no plates, and where the mark cannot be
    measured on them.
    """
    mark = next((mark for mark in shot.marks if mark.name == name), None)
    if mark is None:
        raise InputError(f"--follow {name}: there is no such mark. Add --mark {name}=WHAT.")
    distances_m = commands_for(args.plate).distances_m(args, shot, mark)
    hidden = [frame for frame, distance_m in distances_m.items() if distance_m is None]
    try:
        after = followed(shot, distances_m, Follow(**typed_fields(args, Follow)))
    except InputError as error:
        raise InputError(f"--follow {name}: {error}") from None
    if hidden:
        say(
            f"{name} is hidden, or out of the picture, at frames {frames_text(hidden)}: there the "
            "focus moves on to where it is seen again."
        )
    keys = after.curves.of(LensParameter.FOCUS_DISTANCE).keys
    say(f"the focus follows {name} over {len(distances_m)} frames with {len(keys)} keys.")
    return replace(after, lens=_first_focus(after))


def _first_focus(shot: Shot) -> Lens:
    """Return the lens with the focus of the first key, where it was not given."""
    first = shot.curves.of(LensParameter.FOCUS_DISTANCE).keys[0]
    return replace(shot.lens, focus_distance_m=first.value)
