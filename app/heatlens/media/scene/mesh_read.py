"""Read OBJ, PLY and STL files as scenes, with trimesh: triangles, points and simple materials.

OBJ and PLY have v upwards. None of the formats has a unit, so numbers are taken as meters. None
defines the encoding of vertex colors, so they are taken as sRGB, which most programs write.
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
from heatlens.core.base.paths import read_file_bytes, unreadable_error
from heatlens.media.scene.material import Material
from heatlens.media.scene.mesh_make import make_mesh, smooth_normals, unshared_triangles
from heatlens.media.scene.obj_files import FolderFiles
from heatlens.media.scene.picture_read import read_picture
from heatlens.media.scene.ply_strips import (
    point_normals,
    splat_colors,
    strip_triangles,
    triangulate_polygons,
)
from heatlens.media.scene.point_cloud import POINTS_MOST, make_point_solids
from heatlens.media.scene.scene import Instance, Mesh, Scene

if TYPE_CHECKING:
    from trimesh import PointCloud

_CUTOFF = 0.5
_SPLATS_NOTE = (
    "These are Gaussian splats, which heatlens cannot draw: each is a small solid of its colour, "
    "without its size, direction and transparency. Render them as plates with depth instead."
)
_FAR_MOST = 1e9  # nothing can be drawn beyond this distance


@dataclass
class _MeshReader:
    """Collects the meshes, materials and pictures of a file."""

    path: Path
    folder: FolderFiles
    meshes: list[Mesh] = field(default_factory=list)
    names: list[str] = field(default_factory=list)
    materials: list[Material] = field(default_factory=list)
    images: list[NDArray[np.uint8]] = field(default_factory=list)
    notes: dict[str, None] = field(default_factory=dict)  # in order, each once
    _pictures: dict[str, int | None] = field(default_factory=dict)

    def add(self, name: str, geometry: Any) -> None:
        """Add a part of the file as trimesh returned it: triangles, strips or points."""
        geometry = self._convert_strips(geometry)
        faces = getattr(geometry, "faces", None)
        if faces is None or not len(faces):
            self._add_points(name, geometry)
            return
        positions = self._check_rows("vertices", geometry.vertices, 3)
        corners = self._check_rows("triangles", faces, 3)
        if np.min(corners) < 0 or np.max(corners) >= len(positions):
            raise InputError(
                f"{self.path} is damaged: a triangle refers to a vertex that does not exist. "
                "Export it again."
            )
        positions_m, triangles = _convert_to_floats(positions), corners.astype(np.uint32)
        uvs = getattr(geometry.visual, "uv", None)
        if uvs is not None:
            rows = self._check_rows("texture coordinates", uvs, 2, len(positions))
            uvs = _convert_to_floats(rows * (1, -1) + (0, 1))
        normals = self._read_normals(geometry, positions_m, triangles)
        material = self._read_material(geometry.visual)
        colors = None if material.base_color_map is not None else _vertex_colors(geometry)
        if colors is not None:
            material = replace(material, base_color=(1.0, 1.0, 1.0))
        if geometry.visual.kind == "face":  # a color for each triangle, which needs own vertices
            corner_index, triangles = triangles.reshape(-1), unshared_triangles(len(triangles))
            positions_m = positions_m[corner_index]
            normals = None if normals is None else normals[corner_index]
        self.names.append(name)
        self.materials.append(material)
        label, number = f"{self.path}: {name}", len(self.meshes)
        self.meshes.append(make_mesh(label, positions_m, triangles, normals, uvs, number, colors))

    def _convert_strips(self, geometry: Any) -> object:
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
        positions = self._check_rows("points", geometry.vertices, 3).astype(np.float64)
        is_valid = (np.abs(positions) < _FAR_MOST).all(axis=1)
        if not is_valid.all():
            self.notes[
                f"{np.count_nonzero(~is_valid):,} points have no valid position and are left out."
            ] = None
        if not is_valid.any():
            return
        normals, colors = point_normals(geometry), _point_colors(geometry)
        splats = splat_colors(geometry)
        if splats is not None:
            normals, colors = None, _decode_srgb(splats)  # their normals are all 0
            self.notes[_SPLATS_NOTE] = None
        valid_normals = None if normals is None else normals[is_valid]
        solids = make_point_solids(positions[is_valid], radii=None, normals=valid_normals)
        if np.count_nonzero(is_valid) > POINTS_MOST:
            self.notes[f"There are very many points: {POINTS_MOST:,} are drawn, but larger."] = None
        solid_colors = None if colors is None else colors[is_valid][solids.point]
        material = Material() if solid_colors is None else Material(base_color=(1.0, 1.0, 1.0))
        label, number = f"{self.path}: {name}", len(self.meshes)
        solid_positions = _convert_to_floats(solids.positions)
        solid_normals = _convert_to_floats(solids.normals)
        self.names.append(name)
        self.materials.append(material)
        self.meshes.append(
            make_mesh(
                label,
                solid_positions,
                solids.triangles,
                solid_normals,
                uvs=None,
                material=number,
                colors=solid_colors,
            )
        )

    def _check_rows(
        self, label: str, values: object, width: int, count: int | None = None
    ) -> NDArray[np.generic]:
        """Return rows of the file as (N, `width`); raise InputError for short or missing rows.

        A third texture coordinate, which few programs write, is left out.
        """
        rows = np.asarray(values)
        if rows.ndim == 2 and rows.shape[1] > width == 2:
            rows = rows[:, :2]
        has_shape = rows.ndim == 2 and rows.shape[1] == width and rows.dtype.kind in "fiu"
        if not has_shape or (count is not None and len(rows) != count):
            number = "" if count is None else f"{count} "
            shape = " x ".join(map(str, rows.shape))
            raise InputError(
                f"{self.path} is damaged: there should be {number}{label} of {width} numbers each, "
                f"not {shape}. Export it again."
            )
        return rows

    def _read_normals(
        self, geometry: Any, positions: NDArray[np.float32], triangles: NDArray[np.uint32]
    ) -> NDArray[np.float32] | None:
        """Return the normals of the file, or smooth ones for a PLY, which is taken as a scan.

        Returns None for other files without normals, which are then shaded flat.
        """
        # trimesh computes missing normals; only its cache shows whether the file had any.
        if self.path.suffix.lower() != ".stl" and "vertex_normals" in geometry._cache:
            normals = geometry.vertex_normals
            return _convert_to_floats(self._check_rows("normals", normals, 3, len(positions)))
        if self.path.suffix.lower() == ".ply" and np.isfinite(positions).all():
            return smooth_normals(positions, triangles)
        return None

    def _read_material(self, visual: object) -> Material:
        """Return the material of an OBJ's `mtllib`; the default one if there is none."""
        material = getattr(visual, "material", None)
        entries = getattr(material, "kwargs", None)
        if material is None or not entries:
            return Material()
        shininess, alpha = _read_row(entries, "ns", (0.0,))[0], _read_row(entries, "d", (1.0,))[0]
        picture = self._read_picture(material)
        red, green, blue = (
            (1.0,) * 3 if picture is not None else _read_row(entries, "kd", (0.8,) * 3)
        )
        glow = _read_row(entries, "ke", (0.0,) * 3)
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

    def _read_picture(self, material: Any) -> int | None:
        """Return the index of a material's color map among the images, or None."""
        name = getattr(material.image, "info", {}).get("file_path")
        if name is None:
            return None
        if name not in self._pictures:
            data, label = self.folder.get(name), f"{self.path}: {name}"
            self.images.append(read_picture(data, label, self.images))
            self._pictures[name] = len(self.images) - 1
        return self._pictures[name]


def read_mesh(path: Path) -> Scene:
    """Read an OBJ, PLY or STL file as a scene.

    Raises InputError if it is damaged or trimesh is not installed.
    """
    trimesh = _trimesh()
    try:
        data = read_file_bytes(path)
    except OSError as error:
        raise unreadable_error(path, error) from error
    if not data:
        raise InputError(f"{path} is empty: it holds no scene.")
    if path.suffix.lower() == ".ply":
        data = triangulate_polygons(data)
    reader = _MeshReader(path, FolderFiles(path))
    with _note_logged_errors(reader.notes):
        for name, geometry in _load_parts(trimesh, path, data, reader.folder):
            reader.add(name, geometry)
    # A truncated binary STL looks like text without triangles.
    if path.suffix.lower() == ".stl" and not reader.meshes:
        raise InputError(
            f"{path} is cut short or not in the format STL: no triangle can be read. Export it "
            "again."
        )
    missing = [f"{name} is missing, and is left out." for name in reader.folder.missing]
    return Scene(
        path,
        tuple(reader.meshes),
        tuple(Instance(name, mesh=i, to_world=np.eye(4)) for i, name in enumerate(reader.names)),
        tuple(reader.materials) or (Material(),),
        tuple(reader.images),
        notes=tuple(f"{path}: {note}" for note in dict.fromkeys([*missing, *reader.notes])),
    )


def _trimesh() -> ModuleType:
    return import_extra("trimesh")


class _ErrorNotes(logging.Handler):
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
def _note_logged_errors(notes: dict[str, None]) -> Iterator[None]:
    """Add the errors that trimesh logs to the notes; it would print them with tracebacks."""
    log, handler = logging.getLogger("trimesh"), _ErrorNotes(notes)
    log.addHandler(handler)
    try:
        yield
    finally:
        log.removeHandler(handler)


def _load_parts(
    trimesh: ModuleType, path: Path, data: bytes, folder: FolderFiles
) -> Iterator[tuple[str, Any]]:
    """Yield the name and the geometry of each part that trimesh finds in a file's bytes."""
    kind = path.suffix.lower().removeprefix(".")
    try:
        # trimesh imports some libraries only when a file needs them.
        with (
            extra("scene").require(str(path)),
            warnings.catch_warnings(),
            np.errstate(all="ignore"),
        ):
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
            f"{path} is damaged or not in the format {kind.upper()} ({reason}). Export it again."
        ) from error
    yield from parts


def _convert_to_floats(values: object) -> NDArray[np.float32]:
    """Return values as float32; those beyond its range become infinite."""
    with np.errstate(over="ignore"):  # infinite values are refused later
        return np.asarray(values).astype(np.float32)


def _read_row(entries: dict[str, Any], name: str, default: tuple[float, ...]) -> tuple[float, ...]:
    """Return the numbers of a material entry, all at least 0, or the default if it is invalid."""
    value = entries.get(name, default)
    try:
        row = [float(item) for item in (value if isinstance(value, list | tuple) else [value])]
    except (TypeError, ValueError):
        return default
    is_valid = len(row) == len(default) and all(0 <= item < 1e6 for item in row)
    return tuple(row) if is_valid else default


def _vertex_colors(geometry: Any) -> NDArray[np.float32] | None:
    """Return linear colors (V, 3), or (3 T, 3) if triangles share no vertices.

    The formats do not define the encoding of colors; sRGB is the usual one. Alpha is left out,
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
    return np.repeat(_decode_srgb(np.clip(colors, 0, 1)), 3 if kind == "face" else 1, axis=0)


def _point_colors(geometry: "PointCloud") -> NDArray[np.float32] | None:
    """Return linear colors (P, 3) of points; None if there are none for all of them."""
    colors = getattr(geometry, "colors", None)
    if colors is None or np.ndim(colors) != 2 or np.shape(colors)[0] != len(geometry.vertices):
        return None
    return _decode_srgb(np.asarray(colors)[:, :3] / 255)


def _decode_srgb(shares: NDArray[np.floating]) -> NDArray[np.float32]:
    """Decode sRGB values from 0 to 1 as IEC 61966-2-1 defines it."""
    curve = ((shares + 0.055) / 1.055) ** 2.4
    return _convert_to_floats(np.where(shares <= 0.04045, shares / 12.92, curve))
