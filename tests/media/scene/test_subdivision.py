"""Catmull-Clark subdivision against its known properties."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.media.scene.subdivision import Polygons, corner_normals, subdivide

CUBE = np.array(np.meshgrid((-1.0, 1.0), (-1.0, 1.0), (-1.0, 1.0), indexing="ij"))
CUBE = CUBE.reshape(3, 8).T
FACES = np.array(
    [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
)


def cube(**fields):
    return Polygons(CUBE, np.full(6, 4), FACES.reshape(-1), **fields)


def edges_of(faces):
    pairs = np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2)
    return np.unique(np.sort(pairs, axis=1), axis=0)


def grid(count):
    x, y = np.meshgrid(np.arange(count, dtype=float), np.arange(count, dtype=float))
    first = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).reshape(-1, 1)
    corners = (first + np.array([0, 1, count + 1, count])).reshape(-1)
    points = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    return Polygons(points, np.full(len(first), 4), corners)


def test_subdivided_cube_matches_catmull_clark_paper():
    """Face points stay, edges go to 3/4 and corners to 5/9 of the cube's."""
    found = subdivide(cube())
    assert len(found.points) == 8 + 12 + 6 and (found.counts == 4).all() and len(found.counts) == 24
    np.testing.assert_allclose(np.abs(found.points[:8]), 5 / 9)
    edges = np.sort(np.abs(found.points[8:20]), axis=1)
    np.testing.assert_allclose(edges, np.tile((0, 0.75, 0.75), (12, 1)))
    np.testing.assert_allclose(np.sort(np.abs(found.points[20:]), axis=1)[:, 2], 1)


def test_subdivided_cube_with_sharp_creases_keeps_flat_faces():
    edges = edges_of(FACES)
    found = cube(creases=edges[::-1, ::-1], crease_sharpness=np.full(len(edges), 10.0))
    for _ in range(2):
        found = subdivide(found)
    np.testing.assert_allclose(np.abs(found.points).max(axis=1), 1)
    normals = np.unique(corner_normals(found).round(5), axis=0)
    assert len(normals) == 6 and np.abs(normals).sum() == pytest.approx(6)


def test_subdivided_sharp_corner_stays_in_place():
    found = subdivide(subdivide(cube(sharp_points=np.array([3]), point_sharpness=np.array([9.0]))))
    moved = np.linalg.norm(found.points[:8] - CUBE, axis=1)
    assert moved[3] == 0 and (np.delete(moved, 3) > 0.3).all()


def test_subdivided_half_crease_is_midway():
    edges = edges_of(FACES)
    found = [
        subdivide(cube(creases=edges, crease_sharpness=np.full(len(edges), sharp))).points
        for sharp in (0.0, 0.5, 1.0)
    ]
    np.testing.assert_allclose(found[1], (found[0] + found[2]) / 2)


def test_subdivided_flat_sheet_keeps_border_corners_and_uvs():
    sheet = grid(5)
    uvs = sheet.points[sheet.corners][:, :2] / 4
    found = Polygons(sheet.points, sheet.counts, sheet.corners, {"uv": uvs}, np.arange(16))
    for _ in range(2):
        found = subdivide(found)
    assert found.points.min(axis=0).tolist() == [0, 0, 0] == found.points[0].tolist()
    assert found.points.max(axis=0).tolist() == [4, 4, 0]
    np.testing.assert_allclose(
        found.values["uv"] * 4, found.points[found.corners][:, :2], atol=1e-12
    )
    np.testing.assert_allclose(corner_normals(found), np.tile((0, 0, 1), (4 * 256, 1)))
    assert np.bincount(found.faces).tolist() == [16] * 16


@given(st.integers(0, 2**32 - 1))
def test_subdivision_commutes_with_rigid_motion(seed):
    """Meshes with edges of three faces, faces of up to six corners and vertices without a face."""
    random = np.random.default_rng(seed)
    points = random.normal(size=(9, 3))
    faces = [random.permutation(9)[: random.integers(3, 7)] for _ in range(random.integers(1, 8))]
    counts, corners = np.array([len(face) for face in faces]), np.concatenate(faces)
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    subdivided, reference = (
        subdivide(subdivide(Polygons(at, counts, corners))) for at in (points, points @ turn + 5)
    )
    np.testing.assert_allclose(subdivided.points @ turn + 5, reference.points, atol=1e-9)
    assert np.isfinite(corner_normals(subdivided)).all()
    assert (subdivided.points.max(axis=0) <= points.max(axis=0) + 1e-9).all()
