"""Read the headers of a file without its pixels, in about a tenth of a millisecond.

The timecode of a sequence is read here as well, from the header of its first file.
"""

import os
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.timecode import Timecode
from heatlens.media.files.picture_formats import is_picture, movie_of_frame
from heatlens.media.files.quiet import quiet_library
from heatlens.media.plate.exr.exr_read import choose_deep_channels, is_deep_file, open_parts
from heatlens.media.plate.exr.exr_scan import check_exr
from heatlens.media.plate.header.channel_choice import choose_color
from heatlens.media.plate.header.channels import Header
from heatlens.media.plate.header.entries import is_blurred
from heatlens.media.plate.header.timecode import timecode_of
from heatlens.media.sequence.sequence import Sequence

_DEFAULT_OPTIONS = PlateOptions()


def read_color_header(
    path: str | os.PathLike[str], options: PlateOptions = _DEFAULT_OPTIONS
) -> Header:
    """Read the header of the part that holds the colors that `options` choose.

    Raises InputError if the file is missing, damaged or no EXR, or does not have these colors.
    """
    if is_picture(Path(path)):
        from heatlens.media.plate.parts.picture_parts import picture_header

        return picture_header(Path(path), options.picture_curve, options.depth_side)
    layer, eye = options.color_layer, options.eye
    headers = read_headers(path)
    if is_deep_file(Path(path)):
        return headers[choose_deep_channels(Path(path), headers, layer, eye).part]
    return headers[choose_color(Path(path), headers, layer, eye).rgb[0].part]


def read_headers(path: str | os.PathLike[str]) -> list[Header]:
    """Read the header of every part.

    Raises InputError if the file is missing, damaged or no EXR.
    """
    check_exr(Path(path))
    try:
        with quiet_library():
            parts = open_parts(path, header_only=True)
        headers = [part.header for part in parts]
    except (RuntimeError, ValueError, TypeError, OSError, MemoryError, ArithmeticError) as error:
        raise InputError(
            f"The header of {path} cannot be read: it is missing, damaged or not an OpenEXR file "
            f"({error})."
        ) from error
    if not headers:
        raise InputError(f"{path} is damaged: it has no readable part. Write it again.")
    return headers


def first_timecode(sequence: Sequence) -> tuple[int, Timecode] | None:
    """Return the number of the first frame that has a file, and its timecode; None without one."""
    path = sequence.path_at(sequence.present[0])
    timecodes = (timecode_of(attributes) for attributes in read_timing_headers(path))
    timecode = next(
        (found_timecode for found_timecode in timecodes if found_timecode is not None), None
    )
    return None if timecode is None else (sequence.present[0], timecode)


def read_timing_headers(path: Path) -> list[Header]:
    """Return the headers that may hold timecode and frame rate: those of an EXR or of a movie."""
    if movie_of_frame(path) is not None:
        from heatlens.media.plate.parts.picture_parts import picture_header

        return [picture_header(path)]
    return [] if is_picture(path) else read_headers(path)


def is_marked_blurred(path: Path) -> bool:
    """Return whether heatlens wrote this picture through a lens; False if it cannot be read."""
    from heatlens.media.plate.parts.picture_parts import picture_header

    try:
        headers = [picture_header(path)] if is_picture(path) else read_headers(path)
    except InputError:
        return False
    return any(map(is_blurred, headers))
