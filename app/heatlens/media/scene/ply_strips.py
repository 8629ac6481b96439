"""Read the triangle strips of a PLY, in which old scans are stored, and the normals of points.

trimesh reads such a file as points, but keeps its other elements as raw data.

Polygons with different numbers of corners, as Blender writes them, are cut into triangles, because
trimesh can only read a binary PLY whose polygons all have the same number.
"""

import struct
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from trimesh import PointCloud

_NORMAL = ("nx", "ny", "nz")
_SPLAT = ("f_dc_0", "f_dc_1", "f_dc_2")
_CONSTANT_HARMONIC = 0.28209479  # of degree 0: 1 / (2 sqrt(pi))
_END = b"end_header\n"
_TYPES = {
    "char": "i1",
    "int8": "i1",
    "uchar": "u1",
    "uint8": "u1",
    "short": "i2",
    "int16": "i2",
    "ushort": "u2",
    "uint16": "u2",
    "int": "i4",
    "int32": "i4",
    "uint": "u4",
    "uint32": "u4",
    "float": "f4",
    "float32": "f4",
    "double": "f8",
    "float64": "f8",
}
_ORDERS = {b"binary_little_endian": "<", b"binary_big_endian": ">"}
_CODES = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I"}
_CORNERS = ("vertex_indices", "vertex_index")

Bytes = NDArray[np.uint8]


def strip_triangles(cloud: "PointCloud") -> NDArray[np.int64] | None:
    """Return the triangles (T, 3) of the strips in a PLY; None if it has no strips.

    In a strip, each vertex forms a triangle with the two before it, with alternating orientation;
    -1 ends a strip. Indices are not checked.
    """
    strips = _raw_element(cloud, "tristrips")
    if strips is None:
        return None
    triangles = [_triangulate_strip(_finite_numbers(strip)) for strip in _read_lists(strips)]
    return np.concatenate(triangles) if triangles else np.zeros((0, 3), np.int64)


def point_normals(cloud: "PointCloud") -> NDArray[np.float64] | None:
    """Return the normals (V, 3) of the points in a PLY, or None."""
    return _read_columns(cloud, _NORMAL)


def splat_colors(cloud: "PointCloud") -> NDArray[np.float64] | None:
    """Return the colors (V, 3), sRGB values of 0 to 1, of Gaussian splats; None for other points.

    The color is the constant term of their spherical harmonics, as the program of Kerbl et al.
    writes it ("3D Gaussian Splatting for Real-Time Radiance Field Rendering", 2023).
    """
    constant = _read_columns(cloud, _SPLAT)
    return None if constant is None else np.clip(0.5 + _CONSTANT_HARMONIC * constant, 0.0, 1.0)


def _read_columns(cloud: "PointCloud", names: tuple[str, ...]) -> NDArray[np.float64] | None:
    """Return these properties (V, N) of the points in a PLY; None if one is missing."""
    vertices, count = _raw_element(cloud, "vertex"), len(cloud.vertices)
    columns = [_finite_numbers(_raw_column(vertices, name)) for name in names]
    if any(len(column) != count for column in columns):
        return None
    return np.stack(columns, axis=1)


def _finite_numbers(values: object) -> NDArray[np.float64]:
    """Return finite numbers (N,); none if any value is not finite or no number."""
    try:
        numbers = np.asarray(() if values is None else values, np.float64).reshape(-1)
    except (TypeError, ValueError):  # lists of different lengths, or words
        return np.zeros(0)
    return numbers if np.isfinite(numbers).all() else np.zeros(0)


def _triangulate_strip(strip: NDArray[np.generic]) -> NDArray[np.int64]:
    """Return the triangles (T, 3) of strips that -1 separates, without those of no area."""
    corners = np.clip(strip, -1, 2**40).astype(np.int64)
    if len(corners) < 3:
        return np.zeros((0, 3), np.int64)
    rows = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    position = np.arange(len(corners))
    starts = np.maximum.accumulate(np.where(corners == -1, position + 1, 0))
    is_odd = (position[:-2] - starts[:-2]) % 2 == 1
    rows[is_odd] = rows[is_odd][:, [1, 0, 2]]  # all wind the same way then
    is_complete = (rows >= 0).all(axis=1)
    has_area = (rows[:, 0] != rows[:, 1]) & (rows[:, 1] != rows[:, 2]) & (rows[:, 0] != rows[:, 2])
    return np.asarray(rows[is_complete & has_area])


def _raw_element(cloud: "PointCloud", name: str) -> object:
    """Return the data of an element as trimesh has read them; None if there is no such element."""
    raw = cloud.metadata.get("_ply_raw")
    return raw[name].get("data") if isinstance(raw, dict) and name in raw else None


def _read_lists(element: Any) -> list[object]:
    """Return the lists of an element; text and binary files have them in different types."""
    if isinstance(element, dict):
        return list(next(iter(element.values()), []))
    names = element.dtype.names or ()
    if not names:
        return []
    lists = element[names[0]]
    inner_names = lists.dtype.names
    return list(lists[inner_names[-1]] if inner_names else lists)


def _raw_column(element: Any, name: str) -> Any:
    """Return the values of a property of an element; None if there is none."""
    if isinstance(element, dict):
        return element.get(name)
    has_column = element is not None and name in (element.dtype.names or ())
    return element[name] if has_column else None


@dataclass(frozen=True)
class _Element:
    """An element of a PLY header: its line, its count, and its properties as (name, types).

    A property has one type, a list two: that of its length and that of its numbers.
    """

    line: bytes
    count: int
    properties: list[tuple[str, list[str]]]

    @property
    def is_plain(self) -> bool:
        """Whether it has no lists."""
        return all(len(kinds) == 1 for _, kinds in self.properties)

    def dtype(self, corners: int = 0) -> np.dtype[np.void]:
        """Return the NumPy type of a record whose lists all have `corners` numbers."""
        fields: list[tuple[str, str, tuple[int, ...]]] = []
        for name, kinds in self.properties:
            if len(kinds) > 1:
                fields.append((f"{name} count", kinds[0], ()))
            fields.append((name, kinds[-1], (corners,) if len(kinds) > 1 else ()))
        return np.dtype(fields)


def triangulate_polygons(data: bytes) -> bytes:
    """Return a PLY with mixed polygons as one with triangles; return any other file unchanged."""
    head, end, body = data.partition(_END)
    elements = _parse_elements(head)
    names = [element.line.split()[1] for element in elements]
    if not end or b"face" not in names or b"\r" in head:
        return data
    face_index = names.index(b"face")
    face, elements_before = elements[face_index], elements[:face_index]
    lists = [name for name, kinds in face.properties if len(kinds) > 1]
    if not all(element.is_plain for element in elements_before) or lists not in (
        [_CORNERS[0]],
        [_CORNERS[1]],
    ):
        return data
    start = sum(element.count * element.dtype().itemsize for element in elements_before)
    triangles_and_stop = _cut_polygons(body, start, face, lists[0])
    if triangles_and_stop is None:
        return data
    rows, stop = triangles_and_stop
    head = head.replace(face.line, b"element face %d" % len(rows), 1)
    return b"".join([head, end, body[:start], rows.tobytes(), body[stop:]])


def _parse_elements(head: bytes) -> list[_Element]:
    """Return the elements of a binary header; none if it contains an unknown word."""
    elements: list[_Element] = []
    order = ""
    for line in head.splitlines():
        match words := line.split():
            case [b"format", format_name, *_]:
                order = _ORDERS.get(format_name, "")
            case [b"element", _, count] if count.isdigit():
                elements.append(_Element(line, count=int(count), properties=[]))
            case [b"property", *_] if elements:
                name, kinds = words[-1].decode("latin-1"), _property_types(words)
                if not kinds or name in dict(elements[-1].properties):
                    return []
                elements[-1].properties.append((name, [order + kind for kind in kinds]))
    return elements if order else []


def _property_types(words: list[bytes]) -> list[str]:
    """Return the type of a property, or both types of a list; none if a word is unknown."""
    kinds = [word.decode("latin-1") for word in words[1:-1] if word != b"list"]
    is_valid = len(words) > 2 and len(kinds) == (2 if words[1] == b"list" else 1)
    return [_TYPES[kind] for kind in kinds] if is_valid and set(kinds) <= set(_TYPES) else []


def _cut_polygons(
    body: bytes, start: int, face: _Element, name: str
) -> tuple[NDArray[np.void], int] | None:
    """Return the records of triangles, and the offset in the body where the polygons end.

    Returns None if all polygons have the same number of corners, or the file is cut short.
    """
    record, kinds = face.dtype(), dict(face.properties)[name]
    if kinds[0][1] == "f":
        return None
    assert record.fields is not None
    count_offset = record.fields[f"{name} count"][1]
    count, corner_bytes = struct.Struct(kinds[0][0] + _CODES[kinds[0][1:]]), int(kinds[1][2:])
    offsets, sizes, offset = [], [], start
    for _ in range(face.count):
        if offset + record.itemsize > len(body):
            return None
        (size,) = count.unpack_from(body, offset + count_offset)
        offsets.append(offset)
        sizes.append(size)
        offset += record.itemsize + corner_bytes * max(size, 0)
    if offset > len(body) or min(sizes, default=0) < 0 or len(set(sizes)) < 2:
        return None
    return _make_fans(
        np.frombuffer(body, np.uint8), np.array(offsets), np.array(sizes), face, name
    ), offset


def _make_fans(
    body: Bytes, offsets: NDArray[np.int64], sizes: NDArray[np.int64], face: _Element, name: str
) -> NDArray[np.void]:
    """Return the records of the triangles that polygons are cut into.

    `offsets` and `sizes` hold the position in `body` and the number of corners of each polygon. The
    triangles are sorted by the number of corners.
    """
    fans = []
    for size in np.unique(sizes[sizes >= 3]).tolist():
        record, polygon_offsets = face.dtype(size), offsets[sizes == size]
        rows = body[polygon_offsets[:, None] + np.arange(record.itemsize)].reshape(-1).view(record)
        for last in range(2, size):
            triangles = np.zeros(len(rows), face.dtype(3))
            for field in record.names or ():
                triangles[field] = 3 if field == f"{name} count" else 0
                if rows[field].ndim == 1 and field != f"{name} count":
                    triangles[field] = rows[field]
            triangles[name] = rows[name][:, [0, last - 1, last]]
            fans.append(triangles)
    joined = np.zeros(sum(map(len, fans)), face.dtype(3))
    return np.concatenate(fans, out=joined) if fans else joined  # in the byte order of the file
