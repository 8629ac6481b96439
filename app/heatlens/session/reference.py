"""What A is compared with, where that is a file."""

from dataclasses import dataclass
from pathlib import Path

import moderngl

from heatlens.faults import faults_told
from heatlens.model.plate_options import PlateOptions
from heatlens.plate.channel_choice import choose_color
from heatlens.plate.file_parts import color_file_parts
from heatlens.plate.plate import FloatImage
from heatlens.plate.read import read_color


@dataclass(frozen=True, eq=False)
class Reference:
    """B: any EXR with a colour."""

    path: Path
    texture: moderngl.Texture


@faults_told("The reference could not be read")
def read_reference(path: Path) -> tuple[Path, FloatImage]:
    """Return the path and the colours (H, W, 4) of any EXR. Raises HeatlensError."""
    parts = color_file_parts(path, PlateOptions())
    choice = choose_color(path, [header for header, _ in parts], None)
    return path, read_color(path, parts, choice)[0]
