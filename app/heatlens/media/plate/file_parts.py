"""Read the parts of any supported file: a flat or deep EXR, a photo or another picture."""

from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.model.depth_words import DepthSide
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.files.picture_formats import is_picture
from heatlens.media.plate.deep.deep_plate import flattened_part
from heatlens.media.plate.exr.exr_read import is_deep_file, read_parts
from heatlens.media.plate.header.channels import Header, Part
from heatlens.media.plate.parts.picture_parts import color_parts, depth_parts, picture_facts


def color_file_parts(path: Path, options: PlateOptions) -> list[Part]:
    """Read the header and channels of every part, with scene-linear colours.

    A deep file gives one part, its flattened picture. Raises InputError as `read_parts` does.
    """
    if is_picture(path):
        return color_parts(path, options.picture_curve, options.depth_side)
    if options.depth_side is not DepthSide.NONE:
        raise InputError(f"{path} is an EXR, which has depth channels: leave --depth-side out.")
    return [flattened_part(path)] if is_deep_file(path) else read_parts(path)


def depth_file_parts(path: Path) -> list[Part]:
    """Read the parts of a depth file; the values stay as they are stored."""
    if is_picture(path):
        return depth_parts(path)
    return [flattened_part(path)] if is_deep_file(path) else read_parts(path)


def notes_of(header: Header) -> tuple[str, ...]:
    """Return notes about the colours of a photo or picture; none for an EXR."""
    facts = picture_facts(header)
    return () if facts is None else facts.notes
