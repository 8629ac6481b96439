"""Find the nearest visible depth, so that the depth buffer is not wasted on nearer distances."""

from dataclasses import replace
from itertools import combinations

import numpy as np

from heatlens.scene.scene import Array
from heatlens.scene.scene_view import SceneView

_CLOSE_PART = 0.01  # share of the far plane: a farther surface needs no closer look
_JUST_BEFORE = 0.99
_ASIDE_PX = 1.0  # how far a sample may lie outside the picture
# The edges of a box, by the numbers of its corners (corners.py), which differ in one bit.
_EDGES = np.array([(a, b) for a, b in combinations(range(8), 2) if (a ^ b) in (1, 2, 4)])


def with_near_plane(view: SceneView, nearest_m: float) -> SceneView:
    """Return the view with its near plane moved back to just in front of `nearest_m`."""
    near_m = min(_JUST_BEFORE * nearest_m, view.far_m / 2)
    return view if near_m <= view.near_m else replace(view, near_m=near_m)


def nearest_seen_m(view: SceneView, corners_m: Array, lens_radius_m: float) -> float:
    """Return a planar depth in metres; nothing in the boxes `corners_m` (N, 8, 3) is seen nearer.

    The boxes are in world space, seen from every point of a lens of this radius, 0 for a pinhole.
    The depth is 0 or less if the camera is inside a box, and infinite if nothing is visible.
    """
    turn, place = view.world_to_camera[:3, :3], view.world_to_camera[:3, 3]
    corners = np.asarray(corners_m, np.float64) @ turn.T + place
    depths = -corners[:, :, 2]
    least = depths.min(axis=1)
    is_close = least < _CLOSE_PART * view.far_m
    far_enough = least[~is_close].min(initial=np.inf)
    return float(min(far_enough, _clipped(view, corners[is_close], lens_radius_m)))


def _clipped(view: SceneView, corners: Array, lens_radius_m: float) -> float:
    """Return a lower bound of the depth of boxes (N, 8, 3) clipped by the sides of the picture.

    The boxes are in the camera's axes. Each side of the picture is a plane. The visible part of a
    box is inside all four planes, so it is no nearer than the part inside any one of them.
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

    Both arguments are values (N, 8) at the corners, linear in between. The result is infinite if no
    part is inside.
    """
    a, b = _EDGES.T
    from_a = inside[:, a] - inside[:, b]
    is_crossed = (inside[:, a] < 0) != (inside[:, b] < 0)
    part = np.where(is_crossed, inside[:, a] / np.where(is_crossed, from_a, 1.0), 0.0)
    crossed = np.where(is_crossed, depths[:, a] + part * (depths[:, b] - depths[:, a]), np.inf)
    at_corners = np.where(inside >= 0, depths, np.inf)
    return np.asarray(np.minimum(at_corners.min(axis=1), crossed.min(axis=1)))
