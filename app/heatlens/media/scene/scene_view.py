"""The view of a scene through one point of the lens, as a matrix from the world to the picture.

A point at planar depth z and at (x, y) in the camera's axes, in meters, is seen at the column

    W/2 + F (x - u) / z + F u / S        with F = W f / w, the focal length in pixels

through the point (u, v) of a lens focused at S. W is the width of the picture in pixels, w that of
the sensor, and f the focal length. Points at S stay where a pinhole sees them; other points are
shifted by F u (1/S - 1/z), which over the whole lens is the disc of `coc_line`. Source: Haeberli
and Akeley 1990, section 4; a pinhole has u = v = 0. Rows run downwards.

The near plane lies at the nearest visible depth, because the depth buffer would waste its precision
on nearer distances.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np

from heatlens.core.model.focus.coc import axial_dioptres, lens_diameter_m
from heatlens.core.model.focus.focus_offset import LEVEL, FocusOffset, focus_offset_of
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.lens.pupil import Pupil
from heatlens.core.model.shot.camera_track import Pose
from heatlens.media.scene.scene import Array
from heatlens.media.scene.scene_bounds import corners_of

_NEAR_TO_FAR_LEAST = 1e-4  # nearest near plane as a part of the far plane, for 24 bits of depth


# A processor draws a picture in a thousand parts. When each part computed the matrices of its view
# again, Python took a fifth of the time of the picture.
@dataclass(frozen=True, eq=False)
class SceneView:
    """The geometry of a picture.

    world_to_camera  (4, 4)
    size             (width, height) in pixels
    focal_px         focal length in pixels across
    focus_m          planar distance that no point of the lens shifts; may be infinite
    near_m, far_m    planar depths between which objects are drawn
    offset_m         (u, v): the point of the lens in the camera's x and y
    jitter_px        (x, y), to the right and down: the sample's offset from the pixel's middle
    sample           number of the sample within its pixel: a surface of partial coverage covers
                     some of the samples; None for a single sample
    across           how many pixels of the view are samples of one picture pixel, along each axis
    first_row        first row of the picture that is drawn
    rows_above       rows above it in the texture, which belong to other draws
    focus_offset     tilt of the focus plane away from `focus_m`, in pixels of the view
    """

    world_to_camera: Array
    size: tuple[int, int]
    focal_px: float
    focus_m: float
    near_m: float
    far_m: float
    offset_m: tuple[float, float] = (0.0, 0.0)
    jitter_px: tuple[float, float] = (0.0, 0.0)
    sample: int | None = None
    across: int = 1
    first_row: int = 0
    rows_above: int = 0
    focus_offset: FocusOffset = LEVEL

    @cached_property
    def clip_from_world(self) -> Array:
        """Matrix (4, 4) for columns; y of clip space runs down, so row 0 of a texture is on top.

        After the perspective division, z runs from -1 at `near_m` to 1 at `far_m`.
        """
        width, height = self.size
        x, y = 2 * self.focal_px / width, 2 * self.focal_px / height
        u, v = self.offset_m
        near, far = self.near_m, self.far_m
        clip = np.zeros((4, 4))
        # A shift that is the same at every depth is a multiple of w = -z.
        clip[0] = x, 0, -x * u / self.focus_m, -x * u
        clip[1] = 0, -y, y * v / self.focus_m, y * v
        clip[:2] += self._tilt_matrix(x, -y) @ clip[:2]
        clip[0][2] += 2 * self.jitter_px[0] / width
        clip[1][2] += 2 * self.jitter_px[1] / height
        clip[2] = 0, 0, (far + near) / (near - far), 2 * far * near / (near - far)
        clip[3] = 0, 0, -1, 0
        return np.asarray(clip @ self.world_to_camera)

    def _tilt_matrix(self, x: float, y: float) -> Array:
        """Return (2, 2) from the position of a point in a level lens to its shift in a tilted one.

        `x` and `y` are the scales from tangents to clip space. For the point u of a lens whose
        focus plane has the gradient g, a line that a level lens sees at q meets the focus plane at
        p with p - u (g . p) = q.
        """
        tilt = np.array([self.focus_offset.slope[0], -self.focus_offset.slope[1]]) * self.focal_px
        u, scale = np.array(self.offset_m), np.array([x, y])
        return np.asarray(np.outer(scale * u, tilt / scale) / (1.0 - tilt @ u))

    @cached_property
    def world_from_screen(self) -> Array:
        """Matrix (3, 3) from x, y and w of clip space to directions in the world."""
        return np.asarray(np.linalg.inv(self.clip_from_world[[0, 1, 3], :3]), np.float64)

    def pixel_bounds(self, corners_m: Array) -> Array:
        """Return (4, N) the columns and rows between which boxes may be seen: x0, x1, y0, y1.

        `corners_m` (N, 8, 3) are those of the boxes in the world. Only boxes in front of the camera
        have narrow bounds: one that reaches behind it has infinite ones, and one that lies wholly
        behind the near plane has none, with x0 above x1.
        """
        clip = corners_m @ self.clip_from_world[:, :3].T + self.clip_from_world[:, 3]
        x, y, z, w = np.moveaxis(clip, -1, 0)
        bounds = np.full((4, len(corners_m)), np.inf)
        bounds[::2] = -np.inf
        ahead = (w > 0).all(axis=1)
        for row, positions, side_px in ((0, x, self.size[0]), (2, y, self.size[1])):
            at_px = (positions[ahead] / w[ahead] + 1) * side_px / 2
            bounds[row : row + 2, ahead] = at_px.min(axis=1), at_px.max(axis=1)
        bounds[0, (z < -w).all(axis=1)] = np.inf
        return bounds

    @cached_property
    def eye_m(self) -> Array:
        """The point (3,) of the lens in world space."""
        return np.asarray(np.linalg.inv(self.world_to_camera) @ (*self.offset_m, 0.0, 1.0))[:3]


def view_of(pose: Pose, lens: Lens, size: tuple[int, int], box_m: Array) -> SceneView:
    """Return the pinhole view of a scene whose bounds are `box_m` (2, 3)."""
    world_to_camera = pose.world_to_camera
    depths = -(corners_of(box_m) @ world_to_camera[2, :3] + world_to_camera[2, 3])
    far = max(1.01 * float(depths.max()), 1e-3)
    near = max(0.99 * float(depths.min()), _NEAR_TO_FAR_LEAST * far)
    focal_px = size[0] * lens.focal_length_mm / lens.sensor_width_mm
    focus_m, focus_offset = lens.focus_distance_m, focus_offset_of(lens, size)
    return SceneView(
        world_to_camera=world_to_camera,
        size=size,
        focal_px=focal_px,
        focus_m=focus_m,
        near_m=near,
        far_m=far,
        focus_offset=focus_offset,
    )


def refine_view(view: SceneView, factor: int) -> SceneView:
    """Return the same view with `factor` times as many pixels along each axis."""
    width, height = view.size
    fine_size = factor * width, factor * height
    return replace(
        view,
        size=fine_size,
        focal_px=factor * view.focal_px,
        focus_offset=view.focus_offset.scaled(factor),
    )


def pupil_of(lens: Lens) -> Pupil:
    """Return the lens opening through which a scene is seen, at pinhole depths."""
    return Pupil(lens.aperture, lens_diameter_m(lens) / 2, axial_dioptres(lens))


_CLOSE_PART = 0.01  # share of the far plane; boxes beyond it need not be clipped
_NEAR_PLANE_PART = 0.99  # distance of the near plane, as a part of the nearest visible depth
_MARGIN_PX = 1.0  # how far a sample may lie outside the picture
# The edges of a box, by the numbers of its corners (corners.py), which differ in one bit.
_EDGES = np.array([(a, b) for a, b in combinations(range(8), 2) if (a ^ b) in (1, 2, 4)])


def with_near_plane(view: SceneView, nearest_m: float) -> SceneView:
    """Return the view with its near plane moved back to just in front of `nearest_m`."""
    near_m = min(_NEAR_PLANE_PART * nearest_m, view.far_m / 2)
    return view if near_m <= view.near_m else replace(view, near_m=near_m)


def nearest_visible_m(view: SceneView, corners_m: Array, lens_radius_m: float) -> float:
    """Return a lower bound, in meters, of the planar depth of all visible parts of boxes.

    `corners_m` (N, 8, 3) are the corners of the boxes in world space. They are seen from every
    point of a lens of this radius, 0 for a pinhole. The depth is 0 or less if the camera is inside
    a box, and infinite if nothing is visible.
    """
    rotation, translation = view.world_to_camera[:3, :3], view.world_to_camera[:3, 3]
    corners = np.asarray(corners_m, np.float64) @ rotation.T + translation
    depths = -corners[:, :, 2]
    nearest = depths.min(axis=1)
    is_close = nearest < _CLOSE_PART * view.far_m
    nearest_far_box = nearest[~is_close].min(initial=np.inf)
    return float(min(nearest_far_box, _nearest_in_picture(view, corners[is_close], lens_radius_m)))


def _nearest_in_picture(view: SceneView, corners: Array, lens_radius_m: float) -> float:
    """Return a lower bound of the depth of boxes (N, 8, 3) clipped by the sides of the picture.

    The boxes are in the camera's axes. Each side of the picture is a plane. The visible part of a
    box is inside all four planes, so it is no nearer than the part inside any one of them.

    A ray through a point of the lens passes at most R |1 - depth / focus| beside the ray through
    its middle, with R the radius of the lens. The planes are moved outwards by R + R depth / focus,
    which is no less.
    """
    if not len(corners):
        return np.inf
    nearest = np.full(len(corners), -np.inf)
    depths = -corners[:, :, 2]
    for axis in range(2):
        slope = (view.size[axis] / 2 + _MARGIN_PX) / view.focal_px + lens_radius_m / view.focus_m
        for side in (-1.0, 1.0):
            inside_m = slope * depths + lens_radius_m - side * corners[:, :, axis]
            nearest = np.maximum(nearest, _nearest_inside(depths, inside_m))
    return float(nearest.min())


def _nearest_inside(depths: Array, inside: Array) -> Array:
    """Return the least depth (N,) of the part of each box in which `inside` is at least 0.

    Both arguments are values (N, 8) at the corners, linear in between. The result is infinite if no
    part is inside.
    """
    a, b = _EDGES.T
    difference = inside[:, a] - inside[:, b]
    is_crossed = (inside[:, a] < 0) != (inside[:, b] < 0)
    position = np.where(is_crossed, inside[:, a] / np.where(is_crossed, difference, 1.0), 0.0)
    crossing_depths = np.where(
        is_crossed, depths[:, a] + position * (depths[:, b] - depths[:, a]), np.inf
    )
    corner_depths = np.where(inside >= 0, depths, np.inf)
    return np.asarray(np.minimum(corner_depths.min(axis=1), crossing_depths.min(axis=1)))
