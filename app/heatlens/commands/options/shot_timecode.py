"""Find the timecode of frames: from the shot, else from the header of its first file."""

from collections.abc import Callable
from pathlib import Path

from heatlens.base.errors import InputError
from heatlens.files.picture_formats import in_movie, is_picture
from heatlens.model.shot import Shot
from heatlens.model.timecode import Timecode
from heatlens.plate.header.channels import Header
from heatlens.plate.header.timecode import timecode_of
from heatlens.plate.parts.header_read import read_headers
from heatlens.plate.parts.picture_parts import picture_header
from heatlens.sequence.sequence import Sequence, find_sequence


def first_timecode(sequence: Sequence) -> tuple[int, Timecode] | None:
    """Return the first frame that has a file, and the timecode in its header, if there is one."""
    path = sequence.path_at(sequence.present[0])
    timecodes = (timecode_of(attributes) for attributes in headers_of(path))
    timecode = next((one for one in timecodes if one is not None), None)
    return None if timecode is None else (sequence.present[0], timecode)


def headers_of(path: Path) -> list[Header]:
    """Return the headers that may tell timecode and frame rate: of an EXR, or of a movie."""
    if in_movie(path) is not None:
        return [picture_header(path)]
    return [] if is_picture(path) else read_headers(path)


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
