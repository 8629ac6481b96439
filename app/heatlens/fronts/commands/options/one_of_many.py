"""Find whether a file name on the command line stands for one frame or for its whole sequence.

`render` reads the one file; `export` and `shot new` take all frames of its sequence.
"""

import os
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import unreadable_error
from heatlens.fronts.commands.output.say import print_messages
from heatlens.media.files.foreign_formats import describe_other_format
from heatlens.media.files.picture_formats import is_picture
from heatlens.media.sequence.names import parse_frame_name
from heatlens.media.sequence.sequence import Sequence
from heatlens.media.sequence.sequence_search import find_sequence


def frame_in_sequence(text: str) -> tuple[int, Sequence] | None:
    """Return the frame of an existing picture and its sequence; None if it has no other frame."""
    path = Path(os.path.expanduser(text))
    if not names_picture(path) or not os.path.isfile(path):
        return None
    sequence = find_sequence(path)
    frame = sequence.frame_at(path)
    return None if frame is None or sequence.is_single else (frame, sequence)


def names_picture(path: Path) -> bool:
    """Return whether a name has the ending of a picture, even of a format that cannot be read."""
    return path.suffix.lower() == ".exr" or is_picture(path) or bool(describe_other_format(path))


def check_frame_of_file(text: str, frame: int) -> None:
    """Raise InputError if --frame requests another frame than that of the single file `text`."""
    if not os.path.isfile(text):
        raise unreadable_error(Path(text))
    if other_format := describe_other_format(Path(text)):
        raise InputError(f"{text} is {other_format}.")
    found = frame_in_sequence(text)
    own_frame = parse_frame_name(Path(text).name)[1] if found is None else found[0]
    if own_frame == frame:
        return
    if found is None:
        raise InputError(f"{text} is a single picture without a number: leave --frame out.")
    raise InputError(
        f"{text} is frame {own_frame} alone: name {found[1].pattern} to choose one with --frame."
    )


def print_all_frames_taken(text: str) -> None:
    """Print that a shot made from one frame has all frames of its sequence."""
    if (found := frame_in_sequence(text)) is not None:
        frame, sequence = found
        print_messages(
            f"{text} is one of frames {sequence.first}-{sequence.last}, and the shot has them all: "
            f"--frames {frame}-{frame} takes this one alone."
        )


def print_one_frame_exported(text: str, sequence: Sequence) -> None:
    """Print that one frame is exported, because the output is one file."""
    print_messages(
        f"{text} alone is exported, because the output is one file: {sequence.pattern} and an "
        f"output with #### export all {len(sequence.frames)} frames."
    )
