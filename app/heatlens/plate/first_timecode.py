"""Read the timecode of a sequence from the header of its first file."""

from pathlib import Path

from heatlens.files.picture_formats import in_movie, is_picture
from heatlens.model.timecode import Timecode
from heatlens.plate.header.channels import Header
from heatlens.plate.header.timecode import timecode_of
from heatlens.plate.parts.header_read import read_headers
from heatlens.plate.parts.picture_parts import picture_header
from heatlens.sequence.sequence import Sequence


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
