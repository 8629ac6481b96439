"""Read OBJ, PLY and STL files as scenes, with trimesh: triangles, points and simple materials.

OBJ and PLY have v upwards. None of the formats has a unit, so numbers are taken as metres. None
defines the encoding of vertex colours, so they are taken as sRGB, which most programs write.
"""

import io
import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.errors import InputError, MissingPackageError
from heatlens.core.base.extras import extra, import_extra
from heatlens.core.base.outside_text import one_line
from heatlens.core.base.paths import file_bytes, unreadable
from heatlens.media.scene.mesh_make import made_mesh, own_vertices, smooth_normals
from heatlens.media.scene.obj_files import FilesBeside
from heatlens.media.scene.picture_read import read_picture
from heatlens.media.scene.ply_strips import (
    point_normals,
    splat_colors,
    strip_triangles,
    triangulated,
)
from heatlens.media.scene.point_cloud import POINTS_MOST, drawn_points
from heatlens.media.scene.scene import Instance, Material, Mesh, Scene

if TYPE_CHECKING:
    from trimesh import PointCloud

_CUTOFF = 0.5
_SPLATS = (
    "These are Gaussian splats, which heatlens cannot draw: each is a small solid of its colour, "
    "without its size, direction and transparency. Render them as plates with depth instead."
)
_FAR_MOST = 1e9  # nothing can be drawn beyond this distance


@dataclass
class _Reading:
    path: Path
    folder: FilesBeside
    meshes: list[Mesh] = field(default_factory=list)
    names: list[str] = field(default_factory=list)
    materials: list[Material] = field(default_factory=list)
    images: list[NDArray[np.uint8]] = field(default_factory=list)
    notes: dict[str, None] = field(default_factory=dict)  # in order, each once
    _pictures: dict[str, int | None] = field(default_factory=dict)

    def add(self, name: str, geometry: Any) -> None:
        """Add one of the parts that trimesh found."""
        geometry = self._of_strips(geometry)
        faces = getattr(geometry, "faces", None)
        if faces is None or not len(faces):
            self._add_points(name, geometry)
            return
        positions = self._rows("vertices", geometry.vertices, 3)
        corners = self._rows("triangles", faces, 3)
        if np.min(corners) < 0 or np.max(corners) >= len(positions):
            raise InputError(f"{self.path}: a triangle refers to a vertex that does not exist.")
        places, triangles = _floats(positions), corners.astype(np.uint32)
        uvs = getattr(geometry.visual, "uv", None)
        if uvs is not None:
            rows = self._rows("texture coordinates", uvs, 2, len(positions))
            uvs = _floats(rows * (1, -1) + (0, 1))
        normals = self._normals(geometry, places, triangles)
        material = self._material(geometry.visual)
        colors = None if material.base_color_map is not None else _colors(geometry)
        if colors is not None:
            material = replace(material, base_color=(1.0, 1.0, 1.0))
        if geometry.visual.kind == "face":  # each triangle has a colour, so none share vertices
            apart, triangles = triangles.reshape(-1), own_vertices(len(triangles))
            places, normals = places[apart], None if normals is None else normals[apart]
        self.names.append(name)
        self.materials.append(material)
        what, number = f"{self.path}: {name}", len(self.meshes)
        self.meshes.append(made_mesh(what, places, triangles, normals, uvs, number, colors))

    def _of_strips(self, geometry: Any) -> object:
        """Return a geometry with its triangle strips converted to triangles, if it has any."""
        if not hasattr(geometry, "faces") and hasattr(geometry, "metadata"):
            faces = strip_triangles(geometry)
            if faces is not None and len(faces) and len(geometry.vertices):
                return _trimesh().Trimesh(
                    vertices=geometry.vertices,
                    faces=faces,
                    vertex_normals=point_normals(geometry),
                    vertex_colors=geometry.colors,
                    process=False,
                )
        return geometry

    def _add_points(self, name: str, geometry: "PointCloud") -> None:
        """Add points without faces, as scanners write them; for lines, add only a note."""
        if getattr(geometry, "entities", None) is not None or not len(geometry.vertices):
            self.notes["Lines are not drawn; only triangles and points are."] = None
            return
        positions = self._rows("points", geometry.vertices, 3).astype(np.float64)
        is_seen = (np.abs(positions) < _FAR_MOST).all(axis=1)
        if not is_seen.all():
            self.notes[
                f"{np.count_nonzero(~is_seen):,} points have no valid position and are left out."
            ] = None
        if not is_seen.any():
            return
        normals, colors = point_normals(geometry), _point_colors(geometry)
        splats = splat_colors(geometry)
        if splats is not None:
            normals, colors = None, _linear(splats)  # their normals are all 0
            self.notes[_SPLATS] = None
        facing = None if normals is None else normals[is_seen]
        drawn = drawn_points(positions[is_seen], None, facing)
        if np.count_nonzero(is_seen) > POINTS_MOST:
            self.notes[f"There are very many points: {POINTS_MOST:,} are drawn, but larger."] = None
        tint = None if colors is None else colors[is_seen][drawn.point]
        material = Material() if tint is None else Material(base_color=(1.0, 1.0, 1.0))
        what, number = f"{self.path}: {name}", len(self.meshes)
        places, turned = _floats(drawn.positions), _floats(drawn.normals)
        self.names.append(name)
        self.materials.append(material)
        self.meshes.append(made_mesh(what, places, drawn.triangles, turned, None, number, tint))

    def _rows(
        self, what: str, values: object, width: int, count: int | None = None
    ) -> NDArray[np.generic]:
        """Return rows of the file as (N, `width`); raise InputError for short or missing rows.

        A third texture coordinate, which few programs write, is left out.
        """
        rows = np.asarray(values)
        if rows.ndim == 2 and rows.shape[1] > width == 2:
            rows = rows[:, :2]
        is_right = rows.ndim == 2 and rows.shape[1] == width and rows.dtype.kind in "fiu"
        if not is_right or (count is not None and len(rows) != count):
            number = "" if count is None else f"{count} "
            shape = " x ".join(map(str, rows.shape))
            raise InputError(
                f"{self.path} is damaged: there should be {number}{what} of {width} numbers each, "
                f"not {shape}. Export it again."
            )
        return rows

    def _normals(
        self, geometry: Any, positions: NDArray[np.float32], triangles: NDArray[np.uint32]
    ) -> NDArray[np.float32] | None:
        """Return the file's normals; if a PLY has none, it is taken as a scan and made smooth."""
        # trimesh computes missing normals; only its cache shows whether the file had any.
        if self.path.suffix.lower() != ".stl" and "vertex_normals" in geometry._cache:
            normals = geometry.vertex_normals
            return _floats(self._rows("normals", normals, 3, len(positions)))
        if self.path.suffix.lower() == ".ply" and np.isfinite(positions).all():
            return smooth_normals(positions, triangles)
        return None

    def _material(self, visual: object) -> Material:
        material = getattr(visual, "material", None)
        entries = getattr(material, "kwargs", None)
        if material is None or not entries:
            return Material()
        shininess, alpha = _row(entries, "ns", (0.0,))[0], _row(entries, "d", (1.0,))[0]
        picture = self._picture(material)
        red, green, blue = (1.0,) * 3 if picture is not None else _row(entries, "kd", (0.8,) * 3)
        glow = _row(entries, "ke", (0.0,) * 3)
        return Material(
            name=str(material.name),
            base_color=(red, green, blue),
            base_alpha=alpha,
            # Walter et al. 2007 converts a Blinn-Phong exponent to a roughness; alpha is its root.
            roughness=(2 / (shininess + 2)) ** 0.25,
            emission=(glow[0], glow[1], glow[2]),
            alpha_cutoff=_CUTOFF if alpha < 1 or "map_d" in entries else 0.0,
            base_color_map=picture,
        )

    def _picture(self, material: Any) -> int | None:
        """Return the index of a material's colour map among the images, or None."""
        name = getattr(material.image, "info", {}).get("file_path")
        if name is None:
            return None
        if name not in self._pictures:
            data, what = self.folder.get(name), f"{self.path}: {name}"
            self.images.append(read_picture(data, what, self.images))
            self._pictures[name] = len(self.images) - 1
        return self._pictures[name]


def read_mesh(path: Path) -> Scene:
    """Read an OBJ, PLY or STL file.

    Raises InputError if it is damaged or trimesh is not installed.
    """
    trimesh = _trimesh()
    try:
        data = file_bytes(path)
    except OSError as error:
        raise unreadable(path, error) from error
    if not data:
        raise InputError(f"{path} is empty: it holds no scene.")
    if path.suffix.lower() == ".ply":
        data = triangulated(data)
    reading = _Reading(path, FilesBeside(path))
    with _log_told(reading.notes):
        for name, geometry in _parts(trimesh, path, data, reading.folder):
            reading.add(name, geometry)
    # A truncated binary STL looks like text without triangles.
    if path.suffix.lower() == ".stl" and not reading.meshes:
        raise InputError(
            f"{path} is cut short or not in the format STL: no triangle can be read. Export it "
            "again."
        )
    missing = [f"{name} is missing, and is left out." for name in reading.folder.missing]
    return Scene(
        path,
        tuple(reading.meshes),
        tuple(Instance(name, i, np.eye(4)) for i, name in enumerate(reading.names)),
        tuple(reading.materials) or (Material(),),
        tuple(reading.images),
        notes=tuple(f"{path}: {note}" for note in dict.fromkeys([*missing, *reading.notes])),
    )


def _trimesh() -> ModuleType:
    return import_extra("trimesh")


class _Told(logging.Handler):
    """Notes each error that trimesh logs, except missing files, which are noted elsewhere."""

    def __init__(self, notes: dict[str, None]) -> None:
        super().__init__(logging.WARNING)
        self._notes = notes

    def emit(self, record: logging.LogRecord) -> None:
        """Note the first line of a logged error."""
        error = record.exc_info[1] if record.exc_info else None
        if error is not None and not isinstance(error, FileNotFoundError):
            self._notes[f"{one_line(record.getMessage())} {one_line(error)}".strip()] = None


@contextmanager
def _log_told(notes: dict[str, None]) -> Iterator[None]:
    """Note the errors that trimesh logs; it would print them with tracebacks."""
    log, handler = logging.getLogger("trimesh"), _Told(notes)
    log.addHandler(handler)
    try:
        yield
    finally:
        log.removeHandler(handler)


def _parts(
    trimesh: ModuleType, path: Path, data: bytes, folder: FilesBeside
) -> Iterator[tuple[str, Any]]:
    kind = path.suffix.lower().removeprefix(".")
    try:
        # trimesh imports some libraries only when a file needs them.
        with extra("scene").needed(str(path)), warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")  # about damaged numbers and deprecated calls
            scene = trimesh.load_scene(
                io.BytesIO(data), file_type=kind, resolver=folder, process=False
            )
            # Here trimesh reads what it has deferred.
            parts = [(str(name), part) for name, part in scene.geometry.items()]
    except MissingPackageError:
        raise
    except Exception as error:  # trimesh raises any exception for a damaged file
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise InputError(
            f"{path} is damaged or not in the format {kind.upper()} ({reason})."
        ) from error
    yield from parts


def _floats(values: object) -> NDArray[np.float32]:
    with np.errstate(over="ignore"):  # infinite values are refused later
        return np.asarray(values).astype(np.float32)


def _row(entries: dict[str, Any], name: str, default: tuple[float, ...]) -> tuple[float, ...]:
    """Return the numbers of a material entry, all at least 0, or the default if it is invalid."""
    value = entries.get(name, default)
    try:
        row = [float(item) for item in (value if isinstance(value, list | tuple) else [value])]
    except (TypeError, ValueError):
        return default
    usable = len(row) == len(default) and all(0 <= item < 1e6 for item in row)
    return tuple(row) if usable else default


def _colors(geometry: Any) -> NDArray[np.float32] | None:
    """Return linear colours (V, 3), or (3 T, 3) if triangles share no vertices.

    The formats do not define the encoding of colours; sRGB is the usual one. Alpha is left out,
    because scanners fill it with arbitrary values.
    """
    kind = geometry.visual.kind
    if kind in ("vertex", "face"):
        colors = getattr(geometry.visual, f"{kind}_colors")[:, :3] / 255
    else:
        colors = geometry.vertex_attributes.get("color")  # used if it has materials too
    items = geometry.faces if kind == "face" else geometry.vertices
    if colors is None or np.shape(colors) != (len(items), 3):
        return None
    return np.repeat(_linear(np.clip(colors, 0, 1)), 3 if kind == "face" else 1, axis=0)


def _point_colors(geometry: "PointCloud") -> NDArray[np.float32] | None:
    """Return (P, 3) linear colours of points, or None."""
    colors = getattr(geometry, "colors", None)
    if colors is None or np.ndim(colors) != 2 or np.shape(colors)[0] != len(geometry.vertices):
        return None
    return _linear(np.asarray(colors)[:, :3] / 255)


def _linear(shares: NDArray[np.floating]) -> NDArray[np.float32]:
    """Decode sRGB values from 0 to 1 as IEC 61966-2-1 defines it."""
    curve = ((shares + 0.055) / 1.055) ** 2.4
    return _floats(np.where(shares <= 0.04045, shares / 12.92, curve))
