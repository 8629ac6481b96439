"""The prims of a USD stage that are drawn, and the meshes of each.

Sphere, cube, cylinder, cone and so on are the geometric primitives of USD. Point instancers are
many copies of a few prototypes, each with its own transform.
"""

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

from heatlens.core.base.errors import InputError
from heatlens.media.files import usd_library
from heatlens.media.files.usd_library import UsdObject, usd_module
from heatlens.media.scene.mesh_make import make_mesh
from heatlens.media.scene.primitives import Shape, capsule, cube, cylinder, plane, sphere
from heatlens.media.scene.scene import Mesh
from heatlens.media.scene.usd.curves import read_curves, read_points
from heatlens.media.scene.usd.material import UsdMaterials
from heatlens.media.scene.usd.mesh import read_mesh_parts
from heatlens.media.scene.usd.stage import kind_of
from heatlens.media.scene.usd.subdivision import Subdivision

_ERRORS_LISTED = 8
HIDDEN_PURPOSES = ("guide", "proxy")
SHAPE_KINDS = (
    *("Sphere", "Cube", "Cylinder", "Cone", "Capsule", "Plane"),
    *("Cylinder_1", "Capsule_1"),  # newer schemas with two radii
)
_DRAWN_KINDS = ("Mesh", "BasisCurves", "Points", *SHAPE_KINDS)
_LENGTH_NAMES = ("size", "radius", "height", "width", "length", "radiusTop", "radiusBottom")


@dataclass
class UsdGeometry:
    """The meshes of prims; each prim is read once.

    errors  the error of each prim whose data are inconsistent, and which has no mesh
    """

    materials: UsdMaterials
    meshes: list[Mesh] = field(default_factory=list)
    subdivision: Subdivision = field(default_factory=Subdivision)
    errors: list[InputError] = field(default_factory=list)
    _numbers_by_path: dict[object, tuple[int, ...]] = field(default_factory=dict)

    def meshes_of(self, prim: UsdObject) -> tuple[int, ...]:
        """Return the numbers of the meshes of a prim, one for each of its materials."""
        prototype_prim = prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim
        if prototype_prim.GetPath() not in self._numbers_by_path:
            new_meshes = self._read_or_store_error(prim)
            self._numbers_by_path[prototype_prim.GetPath()] = tuple(
                range(len(self.meshes), len(self.meshes) + len(new_meshes))
            )
            self.meshes += new_meshes
        return self._numbers_by_path[prototype_prim.GetPath()]

    @property
    def notes(self) -> list[str]:
        """A sentence on each prim that is left out. Raises the first error if all are left out."""
        if self.errors and not self.meshes:
            raise self.errors[0]
        start = f"{self.materials.stage.path}: "
        sentences = [
            f"Left out: {str(error).removeprefix(start)}" for error in self.errors[:_ERRORS_LISTED]
        ]
        more_count = len(self.errors) - len(sentences)
        return [
            *sentences,
            *([f"Left out for similar reasons: {more_count} more objects."] if more_count else []),
        ]

    def _read_or_store_error(self, prim: UsdObject) -> list[Mesh]:
        """Return the meshes of a prim; if it cannot be read, store the error and return none."""
        try:
            return self._read(prim)
        except InputError as error:
            self.errors.append(error)
            return []

    def _read(self, prim: object) -> list[Mesh]:
        """Return the meshes of a prim by the reader of its kind."""
        kind = kind_of(prim)
        if kind == "BasisCurves":
            return read_curves(self.materials, prim)
        if kind == "Points":
            return read_points(self.materials, prim)
        if kind in SHAPE_KINDS:
            return read_shape(self.materials, prim)
        return read_mesh_parts(self.materials, self.subdivision, prim)


def has_surface(prim: object) -> bool:
    """Return True for a prim that is drawn, unless it is hidden."""
    return kind_of(prim) in _DRAWN_KINDS


def is_shown(prim: object) -> bool:
    """Return True for a prim that is visible and meant for a final picture."""
    image = usd_module("UsdGeom").Imageable(prim)
    return (
        image.ComputeVisibility() != "invisible" and image.ComputePurpose() not in HIDDEN_PURPOSES
    )


def list_undrawn_kinds(prims: Iterable[UsdObject]) -> str:
    """Return a sentence that lists the kinds of surfaces that are not drawn; "" for none."""
    gprim = usd_module("UsdGeom").Gprim
    kinds = Counter(
        str(prim.GetTypeName())
        for prim in prims
        if prim.IsA(gprim) and not has_surface(prim) and is_shown(prim)
    )
    words = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items()))
    return f"Not drawn, of kinds that are not read: {words}." if words else ""


def read_shape(materials: UsdMaterials, prim: UsdObject) -> list[Mesh]:
    """Return the mesh of a shape; an empty list if it has no extent.

    Raises InputError if one of its lengths is negative or not a number.
    """
    label = f"{materials.stage.path}: {prim.GetPath()}"
    shape = _make_shape(label, prim)
    if not len(shape.triangles):
        return []
    material = materials.number_of(prim)
    return [make_mesh(label, shape.positions, shape.triangles, shape.normals, shape.uvs, material)]


def _make_shape(label: str, prim: UsdObject) -> Shape:
    """Return the sphere, cube, plane, capsule, cylinder or cone of a prim. Raises InputError."""
    kind, lengths = kind_of(prim), _read_lengths(label, prim)
    axis = str(prim.GetAttribute("axis").Get()) if prim.HasAttribute("axis") else "Z"
    if axis not in ("X", "Y", "Z"):
        raise InputError(f"{label}: its axis is {axis[:20]!r}, which is not X, Y or Z.")
    radius, height = lengths.get("radius", 0.0), lengths.get("height", 0.0)
    bottom, top = lengths.get("radiusBottom", radius), lengths.get("radiusTop", radius)
    if kind == "Sphere":
        return sphere(radius)
    if kind == "Cube":
        return cube(lengths["size"])
    if kind == "Plane":
        # Across z, the width is along x; across the others it takes the place of the length.
        sides = lengths["width"], lengths["length"]
        return plane(*(sides if axis == "Z" else sides[::-1])).align_to(axis)
    if kind in ("Capsule", "Capsule_1"):
        return capsule(height, bottom, top).align_to(axis)
    return cylinder(height, bottom, 0.0 if kind == "Cone" else top).align_to(axis)


def _read_lengths(label: str, prim: UsdObject) -> dict[str, float]:
    """Return the lengths of a shape at their first values. Raises InputError."""
    first_time = usd_module("Usd").TimeCode.EarliestTime()
    lengths = {}
    for name in _LENGTH_NAMES:
        if prim.HasAttribute(name):
            value = usd_library.checked_number(
                prim.GetAttribute(name).Get(first_time), f"{label}: {name}"
            )
            if not 0 <= value < math.inf:
                raise InputError(f"{label}: its {name} is {value:g}, which is not a length.")
            lengths[name] = value
    return lengths


_ATTRIBUTES = ("positions", "orientations", "orientationsf", "scales", "protoIndices")


def find_animated_attributes(prim: UsdObject) -> list[UsdObject]:
    """Return the attributes of an instancer that change over time."""
    attributes = [prim.GetAttribute(name) for name in _ATTRIBUTES]
    return [
        attribute for attribute in attributes if attribute and attribute.GetNumTimeSamples() > 1
    ]
