"""Plates of a post in front of a textured wall, with the pose of a moving camera in the header."""

from pathlib import Path

import numpy as np

from heatlens.media.plate.header.camera_header import lens_attributes
from support.cards import POST, SIZE, view_of_cards
from support.exr_files import write_file

FIRST, LAST = 1, 7
STEP_M = 0.25
_Z_BACKWARD = np.diag([1.0, 1.0, -1.0, 1.0])


def write_dolly(folder: Path, has_camera: bool = True, moves: bool = True) -> str:
    """Write the frames, and return their pattern."""
    for frame in range(FIRST, LAST + 1):
        view = view_of_cards(STEP_M * (frame - FIRST) * moves, (POST,), frame)
        matrix = (_Z_BACKWARD @ view.world_to_camera).T
        camera_attributes = {"worldToCamera": np.ascontiguousarray(matrix, "f4")}
        lens = lens_attributes(36.0 * view.focal_px[0] / SIZE[1], 1.4, 2.0, 36.0)
        color = np.moveaxis(view.plate.color[..., :3], -1, 0)
        channels = dict(zip("RGB", map(np.ascontiguousarray, color), strict=True))
        depth = {"Z": np.ascontiguousarray(view.plate.depth_m)}
        path = folder / f"dolly.{frame:04d}.exr"
        write_file(path, channels | depth, **lens, **(camera_attributes if has_camera else {}))
    return str(folder / "dolly.####.exr")
