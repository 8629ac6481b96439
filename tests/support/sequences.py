"""A small sequence on disk for tests of the timeline: a ball that comes nearer frame by frame."""

from pathlib import Path
from typing import Any

from support.plates import room
from support.session_files import HEIGHT, WIDTH, write_plate

FIRST, LAST = 1001, 1008


def sequence_files(folder: Path, first: int = FIRST, last: int = LAST, **attributes: Any) -> str:
    """Write the room with all distances 5 % shorter from frame to frame. Return the pattern."""
    for frame in range(first, last + 1):
        frame_file(folder, frame, **attributes)
    return str(folder / "shot.####.exr")


def frame_file(folder: Path, frame: int, **attributes: Any) -> Path:
    """Write one frame of the sequence. Return its path."""
    color, depth = room(WIDTH, HEIGHT)
    return write_plate(
        folder / f"shot.{frame}.exr", color, Z=depth * relative_distance(frame), **attributes
    )


def relative_distance(frame: int) -> float:
    """Return the distances at a frame relative to those of the room."""
    return 0.95 ** (frame - FIRST)
