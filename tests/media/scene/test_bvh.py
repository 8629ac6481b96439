"""Test the trees of boxes that rays pass through: their structure, and that no hit is lost."""

from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from heatlens.render.gpu.shader_constants import BVH_DEPTH_MOST
from heatlens.render.scene_gpu.bvh import (
    LEAF_MOST,
    Bvh,
    build_instance_tree,
    build_mesh_trees,
    build_tree,
)
from support.ray_oracle import hit_distances, random_triangles

Array = NDArray[np.float64]
Ray = tuple[Array, Array]


def walk_nodes(nodes: NDArray[np.void], root: int = 0) -> Iterator[tuple[np.void, int, int | None]]:
    """Return every node below a root, with its depth and where its parent is."""
    left: list[tuple[int, int, int | None]] = [(root, 0, None)]
    while left:
        at, depth, parent = left.pop()
        node = nodes[at]
        yield node, depth, parent
        if node["count"] < 0:
            left += [(int(node["first"]) + k, depth + 1, at) for k in range(2)]


def check_tree(tree: Bvh, low: NDArray[np.float32], high: NDArray[np.float32], most: int) -> None:
    """Check that each item is in one leaf and its box, child boxes in parents', and the depth."""
    seen: list[int] = []
    for node, depth, parent in walk_nodes(tree.nodes):
        assert depth <= BVH_DEPTH_MOST
        if parent is not None:
            assert np.all(node["low"] >= tree.nodes[parent]["low"])
            assert np.all(node["high"] <= tree.nodes[parent]["high"])
        if node["count"] < 0:
            continue
        assert 1 <= node["count"] <= most
        items = tree.order[node["first"] : node["first"] + node["count"]]
        assert np.all(low[items] >= node["low"])
        assert np.all(high[items] <= node["high"])
        seen += items.tolist()
    assert sorted(seen) == list(range(len(low)))


corners = st.integers(1, 60).flatmap(
    lambda n: arrays(np.float32, (n, 2, 3), elements=st.floats(-1e4, 1e4, width=32))
)


@given(corners, st.sampled_from([1, LEAF_MOST]))
def test_bvh_has_every_item_in_one_leaf_inside_its_box(
    boxes: NDArray[np.float32], most: int
) -> None:
    low, high = boxes.min(axis=1), boxes.max(axis=1)
    check_tree(build_tree(low, high, most), low, high, most)


@pytest.mark.parametrize("growth", [0.0, 1.0, 1.6])
def test_bvh_stays_shallow_over_geometrically_spaced_items(growth: float) -> None:
    """Each step is `growth` times the one before: all but one item fall into the first bin."""
    steps = np.cumprod(np.full(150, growth)) if growth else np.zeros(150)
    low = np.stack([steps, steps * 0, steps * 0], axis=1).astype(np.float32)
    check_tree(build_tree(low, low, 1), low, low, 1)


def triangles_met(nodes: NDArray[np.void], root: int, ray: Ray) -> list[int]:
    """Return the triangles of the leaves that a ray goes through."""
    found: list[int] = []
    left = [root]
    while left:
        node = nodes[left.pop()]
        sides = (np.stack([node["low"], node["high"]]).astype(np.float64) - ray[0]) / ray[1]
        if sides.min(axis=0).max() > sides.max(axis=0).min():
            continue
        first, count = int(node["first"]), int(node["count"])
        found_here = range(first, first + count)
        left += [first, first + 1] if count < 0 else []
        found += found_here
    return found


def test_bvh_ray_hits_equal_hits_among_all_triangles(rng: np.random.Generator) -> None:
    """The second of two meshes is tested, so that offsets of the first are covered."""
    meshes = random_triangles(rng, 7), random_triangles(rng, 900)
    trees = build_mesh_trees(meshes)
    positions = np.concatenate([mesh.positions_m for mesh in meshes]).astype(np.float64)
    mesh_points = meshes[1].positions_m[meshes[1].triangles].astype(np.float64)
    hits = 0
    for _ in range(150):
        start = 3 * rng.normal(size=3)
        ray = start, rng.uniform(-1, 1, 3) - start
        among = triangles_met(trees.nodes, int(trees.roots[1]), ray)
        in_tree = hit_distances(*ray, positions[trees.triangles[among, :3]])
        nearest = hit_distances(*ray, mesh_points).min()
        assert min(in_tree, default=np.inf) == pytest.approx(nearest)
        assert len(among) < len(mesh_points) / 4
        hits += np.isfinite(nearest)
    assert hits > 20


def test_build_mesh_trees_of_empty_mesh_returns_an_empty_leaf(rng: np.random.Generator) -> None:
    empty = random_triangles(rng, 0)
    trees = build_mesh_trees([empty, random_triangles(rng, 1)])
    assert [trees.nodes[root]["count"] for root in trees.roots] == [0, 1]


def test_build_instance_tree_makes_boxes_around_placed_corners(rng: np.random.Generator) -> None:
    """Positions far from the origin are included, where float32 has few digits left."""
    low = rng.uniform(-1, 0, (40, 3))
    boxes = np.stack([low, low + rng.uniform(0, 1, (40, 3))], axis=1)
    matrices = np.tile(np.eye(4), (40, 1, 1))
    matrices[:, :3, :3] = rng.normal(size=(40, 3, 3))
    matrices[:, :3, 3] = rng.normal(size=(40, 3)) * 1e4
    tree = build_instance_tree(boxes, matrices)
    picks = np.indices((2, 2, 2)).reshape(3, 8).T
    for node, _, _ in walk_nodes(tree.nodes):
        if node["count"] < 0:
            continue
        i = int(tree.order[node["first"]])
        all_corners = np.where(picks == 0, boxes[i, 0], boxes[i, 1])
        placed = all_corners @ matrices[i, :3, :3].T + matrices[i, :3, 3]
        assert np.all(placed >= node["low"].astype(np.float64))
        assert np.all(placed <= node["high"].astype(np.float64))


def test_build_instance_tree_makes_one_leaf_per_instance(rng: np.random.Generator) -> None:
    boxes = np.tile(np.array([[0.0, 0, 0], [1, 1, 1]]), (9, 1, 1))
    tree = build_instance_tree(boxes, np.tile(np.eye(4), (9, 1, 1)))
    leaves = [node["count"] for node, _, _ in walk_nodes(tree.nodes) if node["count"] >= 0]
    assert leaves == [1] * 9
