"""What a PLY holds besides polygons: strips of triangles, as scans of old are stored, and normals.

trimesh reads such a file as points; it keeps everything else that it has read of it.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

_NORMAL = ("nx", "ny", "nz")


def strip_triangles(cloud: Any) -> NDArray[np.int64] | None:
    """Return (T, 3) the triangles of the strips in a PLY; None where it has no strips.

    In a strip every vertex makes a triangle with the two before it, turned the other way each time;
    -1 ends a strip. Indices are not checked.
    """
    told = _element(cloud, "tristrips")
    if told is None:
        return None
    found = [_of_strip(_numbers(strip)) for strip in _lists(told)]
    return np.concatenate(found) if found else np.zeros((0, 3), np.int64)


def point_normals(cloud: Any) -> NDArray[np.float64] | None:
    """Return (V, 3) normals that a PLY has for its points, or None."""
    told, count = _element(cloud, "vertex"), len(cloud.vertices)
    columns = [_numbers(_column(told, name)) for name in _NORMAL]
    if any(len(column) != count for column in columns):
        return None
    return np.stack(columns, axis=1)


def _numbers(told: Any) -> NDArray[np.float64]:
    """Return (N,) finite numbers; none where there are others, or no numbers."""
    try:
        found = np.asarray(() if told is None else told, np.float64).reshape(-1)
    except (TypeError, ValueError):  # of lists of several lengths, or of words
        return np.zeros(0)
    return found if np.isfinite(found).all() else np.zeros(0)


def _of_strip(strip: NDArray[Any]) -> NDArray[np.int64]:
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


def _element(cloud: Any, name: str) -> Any:
    raw = cloud.metadata.get("_ply_raw")
    return raw[name].get("data") if isinstance(raw, dict) and name in raw else None


def _lists(told: Any) -> list[Any]:
    """Return the lists of an element, which text and binary files have in other shapes."""
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
