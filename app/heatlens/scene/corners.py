"""The corners of boxes, where they were made and where they are placed."""

import numpy as np

from heatlens.scene.scene import Array

_PICKS = np.indices((2, 2, 2)).reshape(3, 8).T  # the least or the greatest, axis by axis


def corners_of(boxes_m: Array) -> Array:
    """(..., 8, 3) of boxes (..., 2, 3), each a least and a greatest corner."""
    return np.asarray(np.where(_PICKS == 0, boxes_m[..., :1, :], boxes_m[..., 1:, :]))


def placed_corners(boxes_m: Array, to_world: Array) -> Array:
    """(N, 8, 3) of boxes (N, 2, 3), each in the axes of a matrix (N, 4, 4), in the world."""
    turned = corners_of(boxes_m) @ to_world[:, :3, :3].transpose(0, 2, 1)
    return np.asarray(turned + to_world[:, None, :3, 3])
