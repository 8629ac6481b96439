"""Test shapes without triangles of their own, thin tubes and points: volume, size, direction."""

import numpy as np
import pytest

from heatlens.media.scene.point_cloud import POINTS_MOST, closing_radius, make_point_solids
from heatlens.media.scene.primitives import capsule, cube, cylinder, make_tubes, plane, sphere

SHAPES = {
    "sphere": (sphere(2.0), 4 / 3 * np.pi * 8, (4, 4, 4)),
    "cube": (cube(3.0), 27, (3, 3, 3)),
    "cylinder": (cylinder(5.0, 1.0, 1.0), 5 * np.pi, (2, 2, 5)),
    "cone": (cylinder(5.0, 1.0, 0.0), 5 / 3 * np.pi, (2, 2, 5)),
    "frustum": (cylinder(3.0, 1.0, 2.0), np.pi * (1 + 2 + 4), (4, 4, 3)),
    "capsule": (capsule(3.0, 1.0, 1.0), np.pi * (3 + 4 / 3), (2, 2, 5)),
}


@pytest.mark.parametrize("axis", ["X", "Y", "Z"])
@pytest.mark.parametrize("name", SHAPES)
def test_shape_is_closed_has_its_size_and_faces_outward(name, axis):
    shape, volume, size = SHAPES[name]
    shape = shape.align_to(axis)
    at = shape.positions[shape.triangles].astype(float)
    found = np.einsum("ij,ij->i", at[:, 0], np.cross(at[:, 1], at[:, 2])).sum() / 6
    assert found == pytest.approx(volume, rel=8e-3)
    wide, _, high = size
    expected = np.where(np.array(list("XYZ")) == axis, high, wide)
    np.testing.assert_allclose(np.ptp(shape.positions, axis=0), expected, rtol=1e-5)
    facing = np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0])
    normals = shape.normals[shape.triangles].mean(axis=1)
    assert ((facing * normals).sum(axis=1) > 0).all()
    np.testing.assert_allclose(np.linalg.norm(shape.normals, axis=1), 1, atol=1e-6)
    assert shape.uvs.min() >= 0 and shape.uvs.max() <= 1


def test_plane_and_empty_shapes_have_expected_geometry():
    found = plane(2.0, 6.0)
    assert np.ptp(found.positions, axis=0).tolist() == [2, 6, 0]
    assert (found.normals == (0, 0, 1)).all()
    assert not len(sphere(0.0).triangles) and not len(cylinder(0.0, 0.0, 0.0).triangles)


def test_tubes_have_given_radius_and_stay_separate():
    x = np.linspace(0, 1, 20)
    points = np.vstack([np.column_stack([x, 0 * x, 0 * x]), np.column_stack([0 * x, x, 0 * x + 5])])
    at, normals, triangles, owner = make_tubes(points, np.full(40, 0.01), np.array([20, 20]), 6)
    np.testing.assert_allclose(np.linalg.norm(at - points[owner], axis=1), 0.01)
    np.testing.assert_allclose(at - points[owner], 0.01 * normals, atol=1e-12)
    assert len(triangles) == 2 * 19 * 6 * 2
    assert ((owner[triangles] < 20).all(axis=1) | (owner[triangles] >= 20).all(axis=1)).all()


def test_crossed_tubes_are_two_bands_through_the_curve():
    points = np.column_stack([np.linspace(0, 1, 20), np.zeros(20), np.zeros(20)])
    at, _, triangles, owner = make_tubes(
        points, np.full(20, 0.01), np.array([20]), 4, is_crossed=True
    )
    assert len(triangles) == 19 * 4
    corners = at[triangles]
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    assert area.sum() / 2 == pytest.approx(2 * 0.02)
    across = (at - points[owner]).reshape(20, 4, 3)
    np.testing.assert_allclose(across[:, :2], -across[:, 2:], atol=1e-12)


def test_point_solids_are_solids_or_discs_that_close_a_surface():
    y, x = np.mgrid[:30, :40] * 0.25
    points = np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()])
    assert closing_radius(points) == pytest.approx(0.7 * 0.25)
    solids = make_point_solids(points)
    assert len(solids.triangles) == 32 * len(points)
    at = solids.positions[solids.triangles] - points[solids.point[solids.triangles]]
    facing = np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0])
    assert ((facing * at.mean(axis=1)).sum(axis=1) > 0).all()
    discs = make_point_solids(
        points, np.full(len(points), 0.1), np.tile((0, 0, 2.0), (len(points), 1))
    )
    at = discs.positions[discs.triangles]
    area = np.linalg.norm(np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0]), axis=1).sum() / 2
    assert area == pytest.approx(len(points) * np.pi * 0.01)
    assert (discs.normals == (0, 0, 1)).all() and np.ptp(discs.positions[:, 2]) < 1e-12


def test_point_solids_above_limit_are_fewer_and_larger():
    points = np.random.default_rng(1).normal(size=(2 * POINTS_MOST, 3))
    drawn = make_point_solids(points, np.full(len(points), 0.1))
    assert len(drawn.positions) == 4 * POINTS_MOST and len(np.unique(drawn.point)) == POINTS_MOST
    distances = np.linalg.norm(drawn.positions - points[drawn.point], axis=1)
    np.testing.assert_allclose(distances, 0.1 * np.sqrt(2), rtol=1e-5)
