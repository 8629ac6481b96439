"""The prims of a USD stage that are drawn, and the meshes of each.

Sphere, cube, cylinder, cone and so on are the geometric primitives of USD.
"""

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

from heatlens.base.errors import InputError
from heatlens.files import usd_library
from heatlens.files.usd_library import UsdObject, usd_module
from heatlens.scene.mesh_make import made_mesh
from heatlens.scene.primitives import Shape, capsule, cube, cylinder, plane, sphere
from heatlens.scene.scene import Mesh
from heatlens.scene.usd.curves import read_curves, read_points
from heatlens.scene.usd.material import UsdMaterials
from heatlens.scene.usd.mesh import read_parts
from heatlens.scene.usd.stage import kind_of
from heatlens.scene.usd.subdivide import Subdivision

_TOLD_MOST = 8
_HIDDEN = ("guide", "proxy")
SHAPE_KINDS = (
    *("Sphere", "Cube", "Cylinder", "Cone", "Capsule", "Plane"),
    *("Cylinder_1", "Capsule_1"),  # newer schemas with two radii
)
_DRAWN = ("Mesh", "BasisCurves", "Points", *SHAPE_KINDS)
_LENGTHS = ("size", "radius", "height", "width", "length", "radiusTop", "radiusBottom")


@dataclass
class UsdGeometry:
    """The meshes of prims, each prim read once.

    refused  the error of each prim that contradicts itself, and so has no mesh
    """

    materials: UsdMaterials
    meshes: list[Mesh] = field(default_factory=list)
    subdivision: Subdivision = field(default_factory=Subdivision)
    refused: list[InputError] = field(default_factory=list)
    _known: dict[object, tuple[int, ...]] = field(default_factory=dict)

    def of(self, prim: UsdObject) -> tuple[int, ...]:
        """Return the numbers of the meshes of a prim, one for each of its materials."""
        own = prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim
        if own.GetPath() not in self._known:
            parts = self._read_or_refused(prim)
            self._known[own.GetPath()] = tuple(
                range(len(self.meshes), len(self.meshes) + len(parts))
            )
            self.meshes += parts
        return self._known[own.GetPath()]

    @property
    def notes(self) -> list[str]:
        """A sentence on each prim that is left out. Raises the first error if nothing is left."""
        if self.refused and not self.meshes:
            raise self.refused[0]
        start = f"{self.materials.stage.path}: "
        told = [f"Left out: {str(e).removeprefix(start)}" for e in self.refused[:_TOLD_MOST]]
        more = len(self.refused) - len(told)
        return [
            *told,
            *([f"Left out for similar reasons: {more} more objects."] if more else []),
        ]

    def _read_or_refused(self, prim: UsdObject) -> list[Mesh]:
        try:
            return self._read(prim)
        except InputError as error:
            self.refused.append(error)
            return []

    def _read(self, prim: object) -> list[Mesh]:
        kind = kind_of(prim)
        if kind == "BasisCurves":
            return read_curves(self.materials, prim)
        if kind == "Points":
            return read_points(self.materials, prim)
        if kind in SHAPE_KINDS:
            return read_shape(self.materials, prim)
        return read_parts(self.materials, self.subdivision, prim)


def has_surface(prim: object) -> bool:
    """Return True for a prim that is drawn, unless it is hidden."""
    return kind_of(prim) in _DRAWN


def is_shown(prim: object) -> bool:
    """Return True for a prim that is visible and meant for a final picture."""
    image = usd_module("UsdGeom").Imageable(prim)
    return image.ComputeVisibility() != "invisible" and image.ComputePurpose() not in _HIDDEN


def left_out(prims: Iterable[UsdObject]) -> str:
    """Return a sentence that lists the kinds of surfaces that are not drawn; "" for none."""
    gprim = usd_module("UsdGeom").Gprim
    kinds = Counter(
        str(prim.GetTypeName())
        for prim in prims
        if prim.IsA(gprim) and not has_surface(prim) and is_shown(prim)
    )
    told = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items()))
    return f"Not drawn, of kinds that are not read: {told}." if told else ""


def read_shape(materials: UsdMaterials, prim: UsdObject) -> list[Mesh]:
    """Return the mesh of a shape; an empty list if it has no extent.

    Raises InputError if a length of it is negative or no number.
    """
    what = f"{materials.stage.path}: {prim.GetPath()}"
    found = _shape(what, prim)
    if not len(found.triangles):
        return []
    material = materials.of(prim)
    return [made_mesh(what, found.positions, found.triangles, found.normals, found.uvs, material)]


def _shape(what: str, prim: UsdObject) -> Shape:
    kind, told = kind_of(prim), _lengths(what, prim)
    axis = str(prim.GetAttribute("axis").Get()) if prim.HasAttribute("axis") else "Z"
    if axis not in ("X", "Y", "Z"):
        raise InputError(f"{what}: its axis is {axis[:20]!r}, which is not X, Y or Z.")
    radius, height = told.get("radius", 0.0), told.get("height", 0.0)
    bottom, top = told.get("radiusBottom", radius), told.get("radiusTop", radius)
    if kind == "Sphere":
        return sphere(radius)
    if kind == "Cube":
        return cube(told["size"])
    if kind == "Plane":
        # Across z, the width is along x; across the others it takes the place of the length.
        sides = told["width"], told["length"]
        return plane(*(sides if axis == "Z" else sides[::-1])).along(axis)
    if kind in ("Capsule", "Capsule_1"):
        return capsule(height, bottom, top).along(axis)
    return cylinder(height, bottom, 0.0 if kind == "Cone" else top).along(axis)


def _lengths(what: str, prim: UsdObject) -> dict[str, float]:
    """Return the lengths of a shape at their first values."""
    first = usd_module("Usd").TimeCode.EarliestTime()
    found = {}
    for name in _LENGTHS:
        if prim.HasAttribute(name):
            value = usd_library.number(prim.GetAttribute(name).Get(first), f"{what}: {name}")
            if not 0 <= value < math.inf:
                raise InputError(f"{what}: its {name} is {value:g}, which is not a length.")
            found[name] = value
    return found
