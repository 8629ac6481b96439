"""Compute the corners of boxes, in their own axes and in the world."""

import numpy as np

from heatlens.scene.scene import Array

# Picks the least or the greatest corner on each axis.
_PICKS = np.indices((2, 2, 2)).reshape(3, 8).T


def corners_of(boxes_m: Array) -> Array:
    """Return the corners (..., 8, 3) of boxes (..., 2, 3), a least and a greatest corner each."""
    return np.asarray(np.where(_PICKS == 0, boxes_m[..., :1, :], boxes_m[..., 1:, :]))


def placed_corners(boxes_m: Array, to_world: Array) -> Array:
    """Return the corners (N, 8, 3) of boxes (N, 2, 3) in the world.

    The matrices `to_world` (N, 4, 4) transform each box from its own axes.
    """
    turned = corners_of(boxes_m) @ to_world[:, :3, :3].transpose(0, 2, 1)
    return np.asarray(turned + to_world[:, None, :3, 3])
