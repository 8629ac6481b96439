"""The parts of any file that is read, an EXR or a picture for the eye."""

from pathlib import Path

from heatlens.files.picture_formats import is_picture
from heatlens.model.plate_options import PlateOptions
from heatlens.plate.channels import Header, Part
from heatlens.plate.exr_read import read_parts
from heatlens.plate.picture_parts import color_parts, depth_parts, told_of


def color_file_parts(path: Path, options: PlateOptions) -> list[Part]:
    """Read header and channels of every part, colours scene-linear. Raises as `read_parts`."""
    return color_parts(path, options.picture_curve) if is_picture(path) else read_parts(path)


def depth_file_parts(path: Path) -> list[Part]:
    """Read the parts of a file that holds a depth, whose values are not converted."""
    return depth_parts(path) if is_picture(path) else read_parts(path)


def notes_of(header: Header) -> tuple[str, ...]:
    """Return what to say about the colours of a picture; nothing for an EXR."""
    told = told_of(header)
    return () if told is None else told.notes
