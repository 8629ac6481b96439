"""Reference intersections of rays in float64, which test every triangle without a tree."""

import numpy as np
from numpy.typing import NDArray

from heatlens.media.scene.scene import Instance, Mesh, Scene
from heatlens.media.scene.scene_view import SceneView

Array = NDArray[np.float64]


def random_triangles(rng: np.random.Generator, count: int, material: int = 0) -> Mesh:
    """Return a mesh of `count` small random triangles in a cube from -1 to 1."""
    middles = rng.uniform(-1, 1, (count, 1, 3))
    positions = (middles + 0.1 * rng.normal(size=(count, 3, 3))).reshape(-1, 3).astype(np.float32)
    triangles = np.arange(3 * count, dtype=np.uint32).reshape(-1, 3)
    zeros = np.zeros_like(positions)
    return Mesh(positions, zeros, zeros[:, :2], triangles, material)


def hit_distances(start: Array, direction: Array, points: Array) -> Array:
    """Return the distance along a ray to each triangle (T, 3, 3), infinite where it misses.

    Source: Moeller and Trumbore 1997.
    """
    a, b = points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]
    normal = np.cross(a, b)
    facing = normal @ direction
    offset = start - points[:, 0]
    cross_product = np.cross(offset, direction)
    u, v = (b * cross_product).sum(axis=1) / -facing, (a * cross_product).sum(axis=1) / facing
    distance = -(offset * normal).sum(axis=1) / facing
    inside = (u >= 0) & (v >= 0) & (u + v <= 1) & (distance > 0)
    return np.where(inside, distance, np.inf)


def hit_materials(scene: Scene, view: SceneView) -> NDArray[np.int64]:
    """Return (H, W) the material that each pixel's ray hits first, -1 for none."""
    meshes = [scene.meshes[instance.mesh] for instance in scene.instances]
    owner = np.repeat([mesh.material for mesh in meshes], [len(mesh.triangles) for mesh in meshes])
    points = np.concatenate(
        [_in_camera(mesh, view.world_to_camera @ i.to_world) for mesh, i in _pairs(scene)]
    )
    width, height = view.size
    materials = np.full((height, width), -1)
    for y, x in np.ndindex(height, width):
        start, direction = _ray(view, x, y)
        distances = hit_distances(start, direction, points)
        distances[(distances < view.near_m) | (distances > view.far_m)] = np.inf
        if np.isfinite(distances.min()):
            materials[y, x] = owner[distances.argmin()]
    return materials


def _pairs(scene: Scene) -> list[tuple[Mesh, Instance]]:
    return [(scene.meshes[instance.mesh], instance) for instance in scene.instances]


def _in_camera(mesh: Mesh, to_camera: Array) -> Array:
    corners = mesh.positions_m[mesh.triangles].astype(np.float64)
    return corners @ to_camera[:3, :3].T + to_camera[:3, 3]


def _ray(view: SceneView, x: int, y: int) -> tuple[Array, Array]:
    """Return start and direction of the ray from a lens point through the pixel's focus point."""
    px = np.array([x, y]) + 0.5 + view.jitter_px - np.array(view.size) / 2
    right, down = px / view.focal_px * view.focus_m
    start = np.array([*view.offset_m, 0.0])
    return start, (np.array([right, -down, -view.focus_m]) - start) / view.focus_m
