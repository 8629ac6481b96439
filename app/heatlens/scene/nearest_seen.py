"""How near the camera anything can be seen, so that depth is not spent on what is nearer still."""

from dataclasses import replace
from itertools import combinations

import numpy as np

from heatlens.scene.scene import Array
from heatlens.scene.scene_view import SceneView

_CLOSE_PART = 0.01  # of the far plane: what is farther needs no closer look
_JUST_BEFORE = 0.99
_ASIDE_PX = 1.0  # by which a sample may lie outside the picture
# The edges of a box, by the numbers of its corners (corners.py), which differ in one bit.
_EDGES = np.array([(a, b) for a, b in combinations(range(8), 2) if (a ^ b) in (1, 2, 4)])


def with_near_plane(view: SceneView, nearest_m: float) -> SceneView:
    """Return the view with its near plane just in front of what is nearest, if that is farther."""
    near_m = min(_JUST_BEFORE * nearest_m, view.far_m / 2)
    return view if near_m <= view.near_m else replace(view, near_m=near_m)


def nearest_seen_m(view: SceneView, corners_m: Array, lens_radius_m: float) -> float:
    """Return a planar depth in metres; nothing in boxes of `corners_m` (N, 8, 3) is seen nearer.

    They lie in the world and are seen from every point of a lens of this radius, 0 for a pinhole.
    The depth is not above 0 where the camera stands in a box, and infinite where nothing is seen.
    """
    turn, place = view.world_to_camera[:3, :3], view.world_to_camera[:3, 3]
    corners = np.asarray(corners_m, np.float64) @ turn.T + place
    depths = -corners[:, :, 2]
    least = depths.min(axis=1)
    is_close = least < _CLOSE_PART * view.far_m
    far_enough = least[~is_close].min(initial=np.inf)
    return float(min(far_enough, _clipped(view, corners[is_close], lens_radius_m)))


def _clipped(view: SceneView, corners: Array, lens_radius_m: float) -> float:
    """Return the least depth that the sides of the picture leave of boxes (N, 8, 3).

    The boxes are in the camera's axes. A side of the picture is a plane. What is seen of a box is
    on the inner side of each of them, and so no nearer than the least depth that any one leaves.
    """
    if not len(corners):
        return np.inf
    least = np.full(len(corners), -np.inf)
    depths = -corners[:, :, 2]
    for axis in range(2):
        slope = (view.size[axis] / 2 + _ASIDE_PX) / view.focal_px + lens_radius_m / view.focus_m
        for side in (-1.0, 1.0):
            inside = slope * depths + lens_radius_m - side * corners[:, :, axis]
            least = np.maximum(least, _least_inside(depths, inside))
    return float(least.min())


def _least_inside(depths: Array, inside: Array) -> Array:
    """Return (N,) the least depth of the part of each box where `inside` is at least 0.

    Both are (N, 8), at the corners, and straight in between. Infinite where no part is inside.
    """
    a, b = _EDGES.T
    from_a = inside[:, a] - inside[:, b]
    is_crossed = (inside[:, a] < 0) != (inside[:, b] < 0)
    part = np.where(is_crossed, inside[:, a] / np.where(is_crossed, from_a, 1.0), 0.0)
    crossed = np.where(is_crossed, depths[:, a] + part * (depths[:, b] - depths[:, a]), np.inf)
    at_corners = np.where(inside >= 0, depths, np.inf)
    return np.asarray(np.minimum(at_corners.min(axis=1), crossed.min(axis=1)))
