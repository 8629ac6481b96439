"""Small scenes for tests: spheres, planes and boxes, as values."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from heatlens.core.model.shot.camera_track import CameraTrack, PoseKey, pose_looking_at
from heatlens.media.scene.material import Material
from heatlens.media.scene.scene import Array, Daylight, Instance, Mesh, Scene, SceneCamera

BLACK = (0.0, 0.0, 0.0)
NIGHT = Daylight(sun=BLACK, zenith=BLACK, horizon=BLACK, ground=BLACK)


def lamp(light: tuple[float, float, float]) -> Material:
    """Return a material that emits exactly this at NIGHT, when there is nothing to reflect."""
    return Material("lamp", base_color=BLACK, emission=light)


def even_sky(light: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Daylight:
    """Return the same light from all around, and no sun."""
    return Daylight(sun=BLACK, zenith=light, horizon=light, ground=light)


def placement(x: float = 0.0, y: float = 0.0, z: float = 0.0, scale: float = 1.0) -> Array:
    """Return a matrix (4, 4) that scales, then moves by x, y and z metres."""
    matrix = np.diag([scale, scale, scale, 1.0])
    matrix[:3, 3] = x, y, z
    return matrix


def sphere(radius_m: float = 1.0, splits: int = 3, material: int = 0) -> Mesh:
    """Return a sphere around the origin of 20 * 4^splits triangles, every corner on it."""
    corners, triangles = icosphere(splits)
    uvs = np.stack(
        [
            np.arctan2(corners[:, 0], corners[:, 2]) / (2 * np.pi) + 0.5,
            np.arccos(np.clip(corners[:, 1], -1, 1)) / np.pi,
        ],
        axis=1,
    )
    return _mesh(radius_m * corners, corners, uvs, triangles, material)


def icosphere(splits: int) -> tuple[Array, Array]:
    """Return unit corners (V, 3) and triangles (T, 3) of an icosahedron with split faces."""
    g = (1 + 5**0.5) / 2
    signs = [(a, b) for a in (-1, 1) for b in (-g, g)]
    points = [p for a, b in signs for p in ((0, a, b), (a, b, 0), (b, 0, a))]
    corners = np.array(points, float) / np.hypot(1, g)
    near = np.linalg.norm(corners[:, None] - corners, axis=-1) < 1.1
    rows = [
        (i, j, k)
        for i in range(12)
        for j in range(i + 1, 12)
        for k in range(j + 1, 12)
        if near[i, j] and near[j, k] and near[i, k]
    ]
    triangles = np.array([_outward(row, corners) for row in rows])
    for _ in range(splits):
        corners, triangles = _split(corners, triangles)
    return corners, triangles


def _outward(row: tuple[int, int, int], corners: Array) -> tuple[int, int, int]:
    i, j, k = row
    turn = np.cross(corners[j] - corners[i], corners[k] - corners[i]) @ corners[i]
    return row if turn > 0 else (i, k, j)


def _split(corners: Array, triangles: Array) -> tuple[Array, Array]:
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=-1).reshape(-1, 2)
    unique, unique_index = np.unique(edges, axis=0, return_inverse=True)
    middles = corners[unique].sum(axis=1)
    middles /= np.linalg.norm(middles, axis=1, keepdims=True)
    a, b, c = triangles.T
    ab, bc, ca = (len(corners) + unique_index.reshape(-1, 3)).T
    parts = [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    return np.concatenate([corners, middles]), np.concatenate([np.stack(p, 1) for p in parts])


def plane(half_m: float = 1.0, facing: str = "z", material: int = 0) -> Mesh:
    """Return a square through the origin, its normal along +x, +y or +z; uv 0..1, v downwards."""
    axis = "xyz".index(facing)
    normal = np.eye(3)[axis]
    right = np.eye(3)[0 if axis else 2]
    up = np.cross(normal, right)
    uvs = np.array([(0, 1), (1, 1), (1, 0), (0, 0)], float)
    corners_uv = 2 * uvs - 1
    corners = half_m * (corners_uv[:, :1] * right - corners_uv[:, 1:] * up)
    return _mesh(corners, np.tile(normal, (4, 1)), uvs, np.array([(0, 1, 2), (0, 2, 3)]), material)


def box(half_m: tuple[float, float, float] = (0.5, 0.5, 0.5), material: int = 0) -> Mesh:
    """Return a box around the origin with flat faces, 12 triangles."""
    sides = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            face = plane(1.0, "xyz"[axis])
            sides.append((face.positions_m + sign * face.normals, sign * face.normals, face.uvs))
    positions, normals, uvs = (np.concatenate(part) for part in zip(*sides, strict=True))
    triangles = np.array([(0, 1, 2), (0, 2, 3)]) + 4 * np.arange(6)[:, None, None]
    return _mesh(positions * half_m, normals, uvs, triangles.reshape(-1, 3), material)


def _mesh(positions: Array, normals: Array, uvs: Array, triangles: Array, material: int) -> Mesh:
    return Mesh(
        positions_m=np.ascontiguousarray(positions, np.float32),
        normals=np.ascontiguousarray(normals, np.float32),
        uvs=np.ascontiguousarray(uvs, np.float32),
        triangles=np.ascontiguousarray(triangles, np.uint32),
        material=material,
    )


def scene_of(
    meshes: Sequence[Mesh],
    places: Sequence[tuple[int, Array]] | None = None,
    materials: Sequence[Material] = (Material(),),
    **fields: object,
) -> Scene:
    """Return a scene; `places` are (mesh, to_world), None leaves each mesh where it was made."""
    placements = [(i, np.eye(4)) for i in range(len(meshes))] if places is None else places
    instances = tuple(
        Instance(f"thing {i}", m, to_world) for i, (m, to_world) in enumerate(placements)
    )
    return Scene(Path("test"), tuple(meshes), instances, tuple(materials), **fields)  # type: ignore[arg-type]


def still_life() -> Scene:
    """Return two spheres, a box and a lamp on a table, and a camera."""
    y, x = np.indices((64, 64)) // 8
    checks = np.where(((x + y) % 2 == 0)[..., None], (230, 220, 200, 255), (70, 60, 60, 255))
    materials = (
        Material("table", base_color=(1.0, 1.0, 1.0), roughness=0.5, base_color_map=0),
        Material("clay", base_color=(0.7, 0.2, 0.1), roughness=0.7),
        Material("gold", base_color=(1.0, 0.75, 0.3), metallic=1.0, roughness=0.25),
        Material("box", base_color=(0.1, 0.3, 0.5), roughness=0.4),
        lamp((40.0, 30.0, 15.0)),
    )
    meshes = (plane(2.0, "y"), *(sphere(0.4, 4, material) for material in (1, 2)))
    meshes += (box((0.25, 0.4, 0.25), 3), sphere(0.05, 2, 4))
    places = [
        (0, placement()),
        (1, placement(-0.5, 0.4, 0.3)),
        (2, placement(0.5, 0.4, -0.6)),
        (3, placement(-0.9, 0.4, -1.0)),
        (4, placement(0.9, 0.15, 0.6)),
        (4, placement(0.2, 0.05, 0.9)),
    ]
    pose = pose_looking_at((0.8, 1.2, 3.6), (0.0, 0.35, 0.0))
    camera = SceneCamera("camera", CameraTrack((PoseKey(1, pose),)), 50.0)
    images = (checks.astype(np.uint8),)
    return scene_of(meshes, places, materials, images=images, cameras=(camera,))
