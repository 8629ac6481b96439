"""Trees of boxes over triangles and over instances, for rays; plain NumPy, without a GPU.

All nodes of a level are split together: items go into bins along each axis, and each node is cut by
the surface area heuristic (Wald 2007, "On fast construction of SAH-based bounding volume
hierarchies"). The two children of a node are neighbors in the array.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from heatlens.media.scene.scene import Array, Mesh
from heatlens.render.gpu.shader_constants import BVH_DEPTH_MOST

Floats = NDArray[np.float32]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

# count > 0: a leaf with the items first .. first + count - 1 of `order`;
# count < 0: children at first and first + 1, cut across the axis -1 - count, the lower one first
NODE = np.dtype([("low", "f4", 3), ("first", "i4"), ("high", "f4", 3), ("count", "i4")])
LEAF_MOST = 4  # triangles in a leaf
_BINS = 8
_EMPTY_BOUND = np.float32(1e30)  # bounds of an empty box


@dataclass(frozen=True, eq=False)
class Bvh:
    """A bounding volume hierarchy: nodes (N,) of `NODE`, the root first, and the order of items.

    The order (n,) lists the items as the leaves refer to them.
    """

    nodes: NDArray[np.void]
    order: Ints


@dataclass(frozen=True, eq=False)
class MeshTrees:
    """The trees of several meshes, one after the other.

    nodes      (N,) of `NODE`; children and triangles are numbered across all meshes
    roots      (meshes,) int32: the root of each tree
    triangles  (T, 4) uint32: three vertices, numbered across all meshes, and the triangle's
               number in its mesh
    """

    nodes: NDArray[np.void]
    roots: NDArray[np.int32]
    triangles: NDArray[np.uint32]


def build_tree(low: Floats, high: Floats, leaf_most: int = LEAF_MOST) -> Bvh:
    """Return the tree over boxes with the corners `low` and `high` (n, 3), n at least 1.

    A leaf has at most `leaf_most` boxes. In a node, count > 0 means a leaf of so many; else its
    children are at `first` and `first` + 1, and -1 - count is the axis of the cut.
    """
    order = np.arange(len(low))
    positions = np.arange(len(low))  # positions in `order` of this level's items, node after node
    counts = np.array([len(low)])
    levels: list[NDArray[np.void]] = []
    node_count = 1
    while len(counts):
        # the items of this level, node after node, and where those of each node start
        items, starts = order[positions], np.cumsum(counts) - counts
        nodes = _boxes(low[items], high[items], starts)
        inner = counts > leaf_most
        nodes["first"], nodes["count"] = positions[starts], counts
        nodes["first"][inner] = node_count + 2 * np.arange(inner.sum())
        is_in_inner = np.repeat(inner, counts)
        positions, items, counts = positions[is_in_inner], items[is_in_inner], counts[inner]
        axis, is_upper = _choose_cuts(low[items], high[items], counts, BVH_DEPTH_MOST - len(levels))
        nodes["count"][inner] = -1 - axis
        # the number of the child, among those of this level, that each item goes to
        halves = 2 * np.repeat(np.arange(len(counts)), counts) + is_upper
        order[positions] = items[np.argsort(halves, kind="stable")]
        levels.append(nodes)
        node_count += 2 * len(counts)
        counts = np.bincount(halves, minlength=2 * len(counts))
    return Bvh(np.concatenate(levels), order)


def _boxes(low: Floats, high: Floats, starts: Ints) -> NDArray[np.void]:
    """Return a node for each of `starts`, with the bounds of the items from there to the next.

    `low` and `high` are the corners (n, 3) of the items' boxes.
    """
    nodes = np.zeros(len(starts), NODE)
    nodes["low"] = np.minimum.reduceat(low, starts)
    nodes["high"] = np.maximum.reduceat(high, starts)
    return nodes


# A node is halved instead of cut by cost if all bins but one are empty. It is halved too if its
# items could not be divided down to single ones in the remaining levels, because the stack of a ray
# in the shader has a fixed size.
def _choose_cuts(low: Floats, high: Floats, counts: Ints, levels_left: int) -> tuple[Ints, Bools]:
    """Return the axis across which each node is cut, and which items go to its upper child.

    `low` and `high` are the boxes (n, 3) of all items, node after node, and `counts` the items of
    each node. `levels_left` is how many levels the tree may have below these nodes.
    """
    if not len(counts):
        return np.zeros(0, np.int64), np.zeros(0, np.bool_)
    # the node of each item, and where the items of each node start
    owner, starts = np.repeat(np.arange(len(counts)), counts), np.cumsum(counts) - counts
    middle = 0.5 * low + 0.5 * high
    least = np.minimum.reduceat(middle, starts)
    spread = np.maximum.reduceat(middle, starts) - least
    share = (middle - least[owner]) / np.where(spread > 0, spread, 1)[owner]
    bins = np.minimum((share * _BINS).astype(np.int64), _BINS - 1)
    costs = np.stack([_costs(low, high, owner * _BINS + bins[:, k], len(counts)) for k in range(3)])
    # the cheapest of all cuts of a node, _BINS - 1 along each axis
    best = costs.transpose(1, 0, 2).reshape(len(counts), -1).argmin(axis=1)
    axis, cut = np.divmod(best, _BINS - 1)
    is_upper = bins[np.arange(len(owner)), axis[owner]] > cut[owner]
    must_halve = np.isinf(costs.min(axis=(0, 2))) | (np.ceil(np.log2(counts)) >= levels_left)
    axis[must_halve] = spread[must_halve].argmax(axis=1)
    _halve(middle, owner, counts, axis, must_halve, is_upper)
    return axis, is_upper


def _costs(low: Floats, high: Floats, bins: Ints, nodes: int) -> Floats:
    """Return (nodes, _BINS - 1) costs of a cut after each bin; infinite for an empty side.

    `low` and `high` are the corners (n, 3) of the items' boxes. `bins` is the bin of each item,
    counted on from node to node: _BINS times the node plus the bin.
    """
    by_bin = np.argsort(bins, kind="stable")
    counts = np.bincount(bins, minlength=nodes * _BINS)
    used = counts > 0
    starts = (np.cumsum(counts) - counts)[used]
    corners = np.full((2, nodes * _BINS, 3), _EMPTY_BOUND, np.float32)
    corners[0, used] = np.minimum.reduceat(low[by_bin], starts)
    corners[1, used] = -np.maximum.reduceat(high[by_bin], starts)  # the maxima, negated
    by_node, numbers = corners.reshape(2, nodes, _BINS, 3), counts.reshape(nodes, _BINS)
    below = np.minimum.accumulate(by_node, axis=2)[:, :, :-1]
    above = np.minimum.accumulate(by_node[:, :, ::-1], axis=2)[:, :, -2::-1]
    number_below = np.cumsum(numbers, axis=1)[:, :-1]
    number_above = numbers.sum(axis=1)[:, None] - number_below
    cost = _area(below) * number_below + _area(above) * number_above
    return np.where((number_below > 0) & (number_above > 0), cost, np.inf)


def _area(corners: Floats) -> Floats:
    """Return half the surface area of boxes (2, ..., 3).

    The first entry has the least corners, and the second the greatest ones negated.
    """
    x, y, z = np.moveaxis(np.maximum(-corners[1] - corners[0], 0), -1, 0)
    return np.asarray(x * y + y * z + z * x)


def _halve(
    middle: Floats, owner: Ints, counts: Ints, axis: Ints, must_halve: Bools, is_upper: Bools
) -> None:
    """Set `is_upper` to half of the items of `must_halve` nodes, to keep the tree shallow.

    The half with the greater `middle` along the `axis` of the node is the upper one. `owner` is the
    node of each item, and `counts` the items of each node.
    """
    items = np.flatnonzero(must_halve[owner])
    owners = owner[items]
    coordinates = middle[items, axis[owners]]
    sorted_items = items[np.lexsort((coordinates, owners))]
    sizes = np.where(must_halve, counts, 0)
    rank = np.arange(len(items)) - (np.cumsum(sizes) - sizes)[owners]
    is_upper[sorted_items] = rank >= counts[owners] // 2


def build_mesh_trees(meshes: Sequence[Mesh]) -> MeshTrees:
    """Return one tree for each mesh; without triangles, it is a root that no ray hits."""
    parts, roots, triangles = [], [], []
    nodes_before = triangles_before = vertices_before = 0
    for mesh in meshes:
        nodes, mesh_triangles = _mesh_tree(mesh)
        nodes["first"] += np.where(nodes["count"] < 0, nodes_before, triangles_before)
        parts.append(nodes)
        roots.append(nodes_before)
        triangles.append(mesh_triangles + vertices_before * np.array([1, 1, 1, 0]))
        nodes_before = nodes_before + len(nodes)
        triangles_before = triangles_before + len(mesh_triangles)
        vertices_before += len(mesh.positions_m)
    rows = np.concatenate(triangles).astype(np.uint32)
    return MeshTrees(nodes=np.concatenate(parts), roots=np.array(roots, np.int32), triangles=rows)


def _mesh_tree(mesh: Mesh) -> tuple[NDArray[np.void], Ints]:
    """Return the nodes and the triangles (T, 4) in leaf order: vertices and own number."""
    corners = mesh.positions_m[mesh.triangles]
    if not len(corners):
        return np.zeros(1, NODE), np.zeros((0, 4), np.int64)
    tree = build_tree(corners.min(axis=1), corners.max(axis=1))
    return tree.nodes, np.column_stack([mesh.triangles[tree.order], tree.order])


def refit_tree(trees: MeshTrees, mesh_index: int, mesh: Mesh) -> NDArray[np.void]:
    """Return the nodes of a mesh's tree, with boxes that fit another shape of the mesh.

    The tree is number `mesh_index` of `trees`, and `mesh` has the new shape. The triangles stay in
    their leaves, which are the nodes with a count above 0: much quicker than building it again.
    """
    ends = [*trees.roots, len(trees.nodes)]
    root = int(ends[mesh_index])
    nodes = trees.nodes[root : int(ends[mesh_index + 1])].copy()
    if not len(mesh.triangles):
        return nodes
    leaves = nodes["count"] > 0
    first = int(nodes["first"][leaves].min())
    triangle_numbers = trees.triangles[first : first + len(mesh.triangles), 3]
    corners = mesh.positions_m[mesh.triangles[triangle_numbers]]
    starts = nodes["first"][leaves] - first
    order = np.argsort(starts)
    leaf_nodes = np.flatnonzero(leaves)[order]
    nodes["low"][leaf_nodes] = np.minimum.reduceat(corners.min(axis=1), starts[order])
    nodes["high"][leaf_nodes] = np.maximum.reduceat(corners.max(axis=1), starts[order])
    # from the lowest level up, so that the boxes of the children are known
    for level in reversed(_levels(nodes["count"] < 0)):
        inner = level[nodes["count"][level] < 0]
        children = nodes["first"][inner] - root
        for name, combine in (("low", np.minimum), ("high", np.maximum)):
            nodes[name][inner] = combine(nodes[name][children], nodes[name][children + 1])
    return nodes


def _levels(is_inner: Bools) -> list[Ints]:
    """Return the nodes of each level of a tree, whose levels follow each other, the root first.

    `is_inner` (nodes,) is true for nodes with children.
    """
    levels, start, count = [], 0, 1
    while count:
        levels.append(np.arange(start, start + count))
        start, count = start + count, 2 * int(is_inner[start : start + count].sum())
    return levels


def build_instance_tree(boxes_m: Array, to_world: Array) -> Bvh:
    """Return the tree over boxes (n, 2, 3) that matrices (n, 4, 4) place in the world.

    Each leaf has one box.
    """
    middle, half = boxes_m.mean(axis=1), (boxes_m[:, 1] - boxes_m[:, 0]) / 2
    rotation = to_world[:, :3, :3]
    middle = np.einsum("nij,nj->ni", rotation, middle) + to_world[:, :3, 3]
    half = np.einsum("nij,nj->ni", np.abs(rotation), half)
    # float32 may round the side of a box inwards
    half = half + 1e-6 * (np.abs(middle) + half)
    return build_tree((middle - half).astype(np.float32), (middle + half).astype(np.float32), 1)
