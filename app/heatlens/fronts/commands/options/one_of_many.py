"""Find what a name on the command line stands for: one frame, or the sequence that it is part of.

Programs count on both: `render` reads the one file, `export` and `shot new` all that belong to it.
"""

import os
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import unreadable
from heatlens.fronts.commands.output.say import say
from heatlens.media.files.foreign_formats import foreign_words
from heatlens.media.files.picture_formats import is_picture
from heatlens.media.sequence.names import form_of
from heatlens.media.sequence.sequence import Sequence, find_sequence


def frame_among(text: str) -> tuple[int, Sequence] | None:
    """Return the frame of an existing picture and its sequence; None if it has no other frame."""
    path = Path(os.path.expanduser(text))
    if not names_picture(path) or not os.path.isfile(path):
        return None
    sequence = find_sequence(path)
    frame = sequence.frame_at(path)
    return None if frame is None or sequence.is_single else (frame, sequence)


def names_picture(path: Path) -> bool:
    """Return whether a name has the ending of a picture, also of one that is not read."""
    return path.suffix.lower() == ".exr" or is_picture(path) or bool(foreign_words(path))


def check_frame_of_file(text: str, frame: int) -> None:
    """Raise InputError if --frame asks one file, which is no sequence, for another frame."""
    if not os.path.isfile(text):
        raise unreadable(Path(text))
    if words := foreign_words(Path(text)):
        raise InputError(f"{text} is {words}.")
    named = frame_among(text)
    own = form_of(Path(text).name)[1] if named is None else named[0]
    if own == frame:
        return
    if named is None:
        raise InputError(f"{text} is a single picture without a number: leave --frame out.")
    raise InputError(
        f"{text} is frame {own} alone: name {named[1].pattern} to choose one with --frame."
    )


def say_all_are_meant(text: str) -> None:
    """Tell that a shot made from one frame has all frames of its sequence."""
    if (named := frame_among(text)) is not None:
        frame, sequence = named
        say(
            f"{text} is one of frames {sequence.first}-{sequence.last}, and the shot has them all: "
            f"--frames {frame}-{frame} takes this one alone."
        )


def say_one_is_meant(text: str, sequence: Sequence) -> None:
    """Tell that one frame is exported, because the output is one file."""
    say(
        f"{text} alone is exported, because the output is one file: {sequence.pattern} and an "
        f"output with #### export all {len(sequence.frames)} frames."
    )
