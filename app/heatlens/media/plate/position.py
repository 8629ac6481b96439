"""Compute depth from a channel of positions, which holds the visible point of each pixel.

In camera space x/z and y/z are linear functions of the pixel, whatever the lens; in world space
they are not. A test of this decides which space the positions are in, and whether the header's
`worldToCamera` belongs to them. That matrix is meant for points as rows; some programs write it for
columns.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError
from heatlens.media.plate.header.channels import ChannelRef, Header, flat_channels
from heatlens.media.plate.header.placement import PLACEMENT, find_placement
from heatlens.media.plate.plate import FloatImage

_LAYERS = (
    *("p", "pworld", "position", "worldposition", "worldpos", "pos", "pcam", "pcamera"),
    *("camerap", "pointposition", "worldpointposition", "ptworld", "pointworld"),
)
_AXES = (("x", "y", "z"), ("r", "g", "b"), ("red", "green", "blue"))
_INFINITE_FROM = 1e10
_SAMPLES = 64  # along each side of the picture
_HITS_LEAST = 32  # fewer samples on surfaces decide nothing
# Deviation from linear, as a part of the range of x/z and y/z; half floats are no more precise.
_LINEAR_WITHIN = 2e-3

Matrix = NDArray[np.float64]


def position_channels(
    headers: Sequence[Header], name: str | None, view: str
) -> tuple[ChannelRef, ChannelRef, ChannelRef] | None:
    """Return the channels x, y and z of a layer of positions, or None if there is none.

    `name` is that of the layer or one of its channels; any other name gives None.
    """
    layers: dict[tuple[int, str], dict[str, ChannelRef]] = {}
    for ref in flat_channels(headers):
        if _is_position_channel(ref, view):
            layers.setdefault((ref.part, ref.layer), {})[ref.leaf.lower()] = ref
    for (_, layer), group in layers.items():
        names = {layer.lower(), *(part for ref in group.values() for part in _lower_names(ref))}
        axes = next((axes for axes in _AXES if set(axes) <= group.keys()), None)
        if axes is not None and (name is None or name.lower() in names):
            return group[axes[0]], group[axes[1]], group[axes[2]]
    return None


def depth_of_positions(
    path: Path, points: FloatImage, layer: str, headers: Sequence[Header]
) -> tuple[FloatImage, str]:
    """Return the planar depth (H, W) of points (H, W, 3), and a sentence on how it was found.

    The depth has the unit of the points, and is infinite where nothing was hit. Raises InputError
    if the points fit neither camera space nor the camera in the header.
    """
    is_hit = np.isfinite(points).all(axis=2) & (np.abs(points) < _INFINITE_FROM).all(axis=2)
    is_hit &= (points != 0).any(axis=2)
    for camera, why in _candidate_cameras(headers):
        camera_points = points.astype(np.float64) @ camera[:3, :3] + camera[3, :3]
        if _is_pinhole_view(camera_points, is_hit):
            depth = np.where(is_hit, np.abs(camera_points[:, :, 2]), np.inf)
            return depth.astype(np.float32), why
    problem = (
        f"its {PLACEMENT} does not belong to them"
        if find_placement(headers) is not None
        else (f"the header has no {PLACEMENT}")
    )
    raise InputError(
        f"{path}: layer {layer!r} holds positions in the world, and {problem}, so their distance "
        "from the camera is not known. Render the depth (Z) as well, or positions in camera space."
    )


def _is_position_channel(ref: ChannelRef, view: str) -> bool:
    """Return True for a channel of `view` whose layer has a usual name for positions."""
    if view and ref.view not in ("", view):
        return False
    word = ref.plain_layer.rpartition(".")[2].lower()
    return "".join(filter(str.isalnum, word)) in _LAYERS


def _lower_names(ref: ChannelRef) -> tuple[str, str]:
    """Return the full name and the name within the part, in lower case."""
    return ref.full_name.lower(), ref.key.lower()


def _candidate_cameras(headers: Sequence[Header]) -> Iterator[tuple[Matrix, str]]:
    """Yield the matrices to try, for points as rows, each with the sentence for the report."""
    yield np.eye(4), "The positions are in camera space: their depth is along its axis."
    matrix = find_placement(headers)
    if matrix is not None:
        why = f"From positions in the world, seen by the camera in {PLACEMENT}."
        yield matrix, why
        yield matrix.T, why


def _is_pinhole_view(points: Matrix, is_hit: NDArray[np.bool_]) -> bool:
    """Return True if x/z and y/z of most points are linear functions of the pixel."""
    height, width = is_hit.shape
    rows = np.unique(np.linspace(0, height - 1, _SAMPLES).astype(int))
    columns = np.unique(np.linspace(0, width - 1, _SAMPLES).astype(int))
    y, x = (grid.ravel() for grid in np.meshgrid(rows, columns, indexing="ij"))
    is_used = is_hit[y, x] & (points[y, x, 2] != 0)
    y, x = y[is_used], x[is_used]
    used_points = points[y, x]
    if (
        len(used_points) < _HITS_LEAST
        or max((used_points[:, 2] > 0).mean(), (used_points[:, 2] < 0).mean()) < 0.99
    ):
        return False
    design = np.stack([np.ones(len(x)), x, y], axis=1)
    return all(_is_linear(used_points[:, axis] / used_points[:, 2], design) for axis in (0, 1))


def _is_linear(values: Matrix, design: Matrix) -> bool:
    """Return True if most values are linear in the pixel; pixels at edges may mix two points.

    `design` holds the rows (1, x, y) of the pixels.
    """
    is_inlier = np.ones(len(values), dtype=bool)
    for _ in range(3):
        plane = design @ np.linalg.lstsq(design[is_inlier], values[is_inlier], rcond=None)[0]
        deviation = np.abs(values - plane)
        is_inlier = deviation <= max(4 * float(np.median(deviation)), 1e-12)
    extent = float(np.ptp(plane))
    return extent > 0 and float(np.quantile(deviation, 0.8)) <= _LINEAR_WITHIN * extent
