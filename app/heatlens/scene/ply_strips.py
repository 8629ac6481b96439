"""Read the triangle strips of a PLY, in which old scans are stored, and the normals of points.

trimesh reads such a file as points, but keeps its other elements as raw data.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

_NORMAL = ("nx", "ny", "nz")


def strip_triangles(cloud: object) -> NDArray[np.int64] | None:
    """Return the triangles (T, 3) of the strips in a PLY; None if it has no strips.

    In a strip, each vertex forms a triangle with the two before it, with alternating orientation;
    -1 ends a strip. Indices are not checked.
    """
    told = _element(cloud, "tristrips")
    if told is None:
        return None
    found = [_of_strip(_numbers(strip)) for strip in _lists(told)]
    return np.concatenate(found) if found else np.zeros((0, 3), np.int64)


def point_normals(cloud: Any) -> NDArray[np.float64] | None:
    """Return the normals (V, 3) of the points in a PLY, or None."""
    told, count = _element(cloud, "vertex"), len(cloud.vertices)
    columns = [_numbers(_column(told, name)) for name in _NORMAL]
    if any(len(column) != count for column in columns):
        return None
    return np.stack(columns, axis=1)


def _numbers(told: object) -> NDArray[np.float64]:
    """Return finite numbers (N,); none if any value is not finite or no number."""
    try:
        found = np.asarray(() if told is None else told, np.float64).reshape(-1)
    except (TypeError, ValueError):  # lists of different lengths, or words
        return np.zeros(0)
    return found if np.isfinite(found).all() else np.zeros(0)


def _of_strip(strip: NDArray[np.generic]) -> NDArray[np.int64]:
    corners = np.clip(strip, -1, 2**40).astype(np.int64)
    if len(corners) < 3:
        return np.zeros((0, 3), np.int64)
    rows = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    at = np.arange(len(corners))
    starts = np.maximum.accumulate(np.where(corners == -1, at + 1, 0))
    is_odd = (at[:-2] - starts[:-2]) % 2 == 1
    rows[is_odd] = rows[is_odd][:, [1, 0, 2]]
    is_whole = (rows >= 0).all(axis=1)
    has_area = (rows[:, 0] != rows[:, 1]) & (rows[:, 1] != rows[:, 2]) & (rows[:, 0] != rows[:, 2])
    return np.asarray(rows[is_whole & has_area])


def _element(cloud: Any, name: str) -> object:
    raw = cloud.metadata.get("_ply_raw")
    return raw[name].get("data") if isinstance(raw, dict) and name in raw else None


def _lists(told: Any) -> list[object]:
    """Return the lists of an element, which have different types for text and binary files."""
    if isinstance(told, dict):
        return list(next(iter(told.values()), []))
    names = told.dtype.names or ()
    if not names:
        return []
    lists = told[names[0]]
    inner = lists.dtype.names
    return list(lists[inner[-1]] if inner else lists)


def _column(told: Any, name: str) -> Any:
    if isinstance(told, dict):
        return told.get(name)
    is_there = told is not None and name in (told.dtype.names or ())
    return told[name] if is_there else None
