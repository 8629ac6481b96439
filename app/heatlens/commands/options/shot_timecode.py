"""Find the timecode of frames: from the shot, else from the header of its first file."""

from collections.abc import Callable

from heatlens.base.errors import InputError
from heatlens.model.shot.shot import Shot
from heatlens.model.timecode import Timecode
from heatlens.plate.parts.header_read import first_timecode
from heatlens.sequence.sequence import find_sequence


def shot_timecodes(shot: Shot, first: int) -> Callable[[int], Timecode | None]:
    """Return a function for the timecode of a frame; `first` is the first frame of a still shot."""
    started = None if shot.start_timecode is not None else _first_of(shot)
    rate = shot.frames_per_second

    def timecode_at(frame: int) -> Timecode | None:
        told = None if started is None else started[1].later(frame - started[0], rate)
        return shot.timecode_at(frame, told, first)

    return timecode_at


def _first_of(shot: Shot) -> tuple[int, Timecode] | None:
    """Return a frame and its timecode; None for scenes and plates that cannot be read yet."""
    try:
        return None if shot.source is None else first_timecode(find_sequence(shot.source))
    except InputError:
        return None
