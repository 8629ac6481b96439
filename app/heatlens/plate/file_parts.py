"""The parts of any file that is read, an EXR or a picture for the eye."""

from pathlib import Path

from heatlens.files.picture_formats import is_picture
from heatlens.model.plate_options import PlateOptions
from heatlens.plate.channels import Header, Part
from heatlens.plate.deep_file import is_deep_file
from heatlens.plate.deep_plate import flattened_part
from heatlens.plate.exr_read import read_parts
from heatlens.plate.picture_parts import color_parts, depth_parts, told_of


def color_file_parts(path: Path, options: PlateOptions) -> list[Part]:
    """Read header and channels of every part, colours scene-linear. Raises as `read_parts`.

    Of a deep file it is one part: what the file shows.
    """
    if is_picture(path):
        return color_parts(path, options.picture_curve)
    return [flattened_part(path)] if is_deep_file(path) else read_parts(path)


def depth_file_parts(path: Path) -> list[Part]:
    """Read the parts of a file that holds a depth, whose values are not converted."""
    if is_picture(path):
        return depth_parts(path)
    return [flattened_part(path)] if is_deep_file(path) else read_parts(path)


def notes_of(header: Header) -> tuple[str, ...]:
    """Return what to say about the colours of a picture; nothing for an EXR."""
    told = told_of(header)
    return () if told is None else told.notes
