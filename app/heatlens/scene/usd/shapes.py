"""Geometric primitives of USD: sphere, cube, cylinder, cone and so on."""

import math

from heatlens.base.errors import InputError
from heatlens.files import usd_values
from heatlens.files.usd_library import UsdObject, usd_module
from heatlens.scene.mesh_make import made_mesh
from heatlens.scene.primitives import Shape, capsule, cube, cylinder, plane, sphere
from heatlens.scene.scene import Mesh
from heatlens.scene.usd.material import UsdMaterials
from heatlens.scene.usd.stage import kind_of

SHAPE_KINDS = (
    *("Sphere", "Cube", "Cylinder", "Cone", "Capsule", "Plane"),
    *("Cylinder_1", "Capsule_1"),  # with two radii, of newer versions
)
_LENGTHS = ("size", "radius", "height", "width", "length", "radiusTop", "radiusBottom")


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
            value = usd_values.number(prim.GetAttribute(name).Get(first), f"{what}: {name}")
            if not 0 <= value < math.inf:
                raise InputError(f"{what}: its {name} is {value:g}, which is not a length.")
            found[name] = value
    return found
