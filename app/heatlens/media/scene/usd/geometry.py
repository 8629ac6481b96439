"""The prims of a USD stage that are drawn, and the meshes of each.

Sphere, cube, cylinder, cone and so on are the geometric primitives of USD. Point instancers are
many copies of a few prototypes, each with its own transform.
"""

import math
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.media.files import usd_library
from heatlens.media.files.usd_library import UsdObject, usd_module
from heatlens.media.scene.mesh_make import make_mesh
from heatlens.media.scene.primitives import Shape, capsule, cube, cylinder, plane, sphere
from heatlens.media.scene.scene import Array, Mesh, check_instances
from heatlens.media.scene.usd.curves import read_curves, read_points
from heatlens.media.scene.usd.material import UsdMaterials
from heatlens.media.scene.usd.mesh import Subdivision, read_mesh_parts
from heatlens.media.scene.usd.stage import UsdStage, kind_of

_ERRORS_LISTED = 8
_HIDDEN_PURPOSES = ("guide", "proxy")
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
        image.ComputeVisibility() != "invisible" and image.ComputePurpose() not in _HIDDEN_PURPOSES
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
    what = f"{materials.stage.path}: {prim.GetPath()}"
    shape = _make_shape(what, prim)
    if not len(shape.triangles):
        return []
    material = materials.number_of(prim)
    return [make_mesh(what, shape.positions, shape.triangles, shape.normals, shape.uvs, material)]


def _make_shape(what: str, prim: UsdObject) -> Shape:
    """Return the sphere, cube, plane, capsule, cylinder or cone of a prim."""
    kind, lengths = kind_of(prim), _read_lengths(what, prim)
    axis = str(prim.GetAttribute("axis").Get()) if prim.HasAttribute("axis") else "Z"
    if axis not in ("X", "Y", "Z"):
        raise InputError(f"{what}: its axis is {axis[:20]!r}, which is not X, Y or Z.")
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


def _read_lengths(what: str, prim: UsdObject) -> dict[str, float]:
    """Return the lengths of a shape at their first values."""
    first_time = usd_module("Usd").TimeCode.EarliestTime()
    lengths = {}
    for name in _LENGTH_NAMES:
        if prim.HasAttribute(name):
            value = usd_library.checked_number(
                prim.GetAttribute(name).Get(first_time), f"{what}: {name}"
            )
            if not 0 <= value < math.inf:
                raise InputError(f"{what}: its {name} is {value:g}, which is not a length.")
            lengths[name] = value
    return lengths


_FAR_MOST = 1e9  # units; beyond it nothing can be drawn
_LEVELS_MOST = 8  # instancers within prototypes of instancers
_ATTRIBUTES = ("positions", "orientations", "orientationsf", "scales", "protoIndices")


@dataclass(frozen=True, eq=False)
class Copies:
    """The meshes that one prim adds, and their transforms in its own space.

    names   (N,) names of the prims that own the meshes
    meshes  (N,) numbers of the meshes
    local   (F, N, 4, 4) from each mesh to the prim; F is 1 where nothing moves within it
    """

    names: tuple[str, ...]
    meshes: tuple[int, ...]
    local: Array


def is_instancer(prim: UsdObject) -> bool:
    """Return True for a point instancer."""
    return bool(prim.IsA(usd_module("UsdGeom").PointInstancer))


def is_within_instancer(prim: UsdObject) -> bool:
    """Return True for a prim below a point instancer: a prototype, which is not drawn itself."""
    parent = prim.GetParent()
    while parent and not parent.IsPseudoRoot():
        if is_instancer(parent):
            return True
        parent = parent.GetParent()
    return False


def find_animated_attributes(prim: UsdObject) -> list[UsdObject]:
    """Return the attributes of an instancer that change over time."""
    attributes = [prim.GetAttribute(name) for name in _ATTRIBUTES]
    return [
        attribute for attribute in attributes if attribute and attribute.GetNumTimeSamples() > 1
    ]


@dataclass
class Instancers:
    """Reads the copies that instancers make."""

    stage: UsdStage
    geometry: UsdGeometry
    notes: dict[str, None] = field(default_factory=dict)

    def read_copies(self, prim: object, frames: FrameRange | None) -> Copies:
        """Return the copies of the instancer over the frames in which its own attributes change.

        Raises InputError if it has too many copies.
        """
        times = list(frames) if frames is not None and find_animated_attributes(prim) else []
        first = self._copies_at(prim, times[0] if times else None, 0)
        locals_ = [first.local]
        for frame in times[1:]:
            frame_copies = self._copies_at(prim, frame, 0)
            if frame_copies.meshes != first.meshes:
                self.notes["An instancer whose copies come and go keeps its first state."] = None
                return first
            locals_.append(frame_copies.local)
        return Copies(first.names, first.meshes, np.concatenate(locals_))

    def _copies_at(self, prim: object, frame: float | None, level: int) -> Copies:
        """Return the copies at a frame (None: the first time), with those of nested instancers.

        `level` counts the instancers around this one.
        """
        usd, geometry = usd_module("Usd"), usd_module("UsdGeom")
        time = usd.TimeCode.EarliestTime() if frame is None else usd.TimeCode(frame)
        instancer = geometry.PointInstancer(prim)
        kinds = np.array(instancer.GetProtoIndicesAttr().Get(time) or [], np.int64)
        check_instances(self.stage.path, len(kinds))
        transforms = np.array(
            instancer.ComputeInstanceTransformsAtTime(
                time, time, geometry.PointInstancer.IncludeProtoXform,
                geometry.PointInstancer.IgnoreMask,
            ),
            np.float64,
        ).reshape(-1, 4, 4).swapaxes(1, 2)  # fmt: skip
        mask = np.array(instancer.ComputeMaskAtTime(time) or np.ones(len(kinds)), bool)
        if not len(transforms) == len(kinds) == len(mask):
            self.notes["A point instancer with inconsistent data is left out."] = None
            return Copies((), (), np.zeros((1, 0, 4, 4)))
        is_drawable = np.asarray((np.abs(transforms) <= _FAR_MOST).all(axis=(1, 2)))
        if not is_drawable[mask].all():
            self.notes["Copies of an instancer at infinity or too far away are left out."] = None
        mask &= is_drawable
        targets = instancer.GetPrototypesRel().GetForwardedTargets()
        names: list[str] = []
        meshes: list[int] = []
        local = [np.zeros((0, 4, 4))]
        for number, path in enumerate(targets):
            kind_transforms = transforms[(kinds == number) & mask]
            if not len(kind_transforms):
                continue
            for name, mesh, inner in self._prototype_meshes(path, time, level):
                names += [name] * len(kind_transforms)
                meshes += [mesh] * len(kind_transforms)
                local.append(kind_transforms @ inner)
                check_instances(self.stage.path, len(names))
        return Copies(tuple(names), tuple(meshes), np.concatenate(local)[None])

    def _prototype_meshes(
        self, path: object, time: object, level: int
    ) -> Iterator[tuple[str, int, Array]]:
        """Yield the meshes of a prototype: name, number, and (4, 4) to the prototype's root."""
        usd, geometry = usd_module("Usd"), usd_module("UsdGeom")
        root = self.stage.stage.GetPrimAtPath(path)
        if not root or level > _LEVELS_MOST:
            return
        cache = geometry.XformCache(time)
        predicate = usd.TraverseInstanceProxies(usd.PrimIsActive & usd.PrimIsLoaded)
        walk = iter(usd.PrimRange(root, predicate))
        for prim in walk:
            if _hides_itself(prim):
                walk.PruneChildren()
                continue
            inner = np.array(cache.ComputeRelativeTransform(prim, root)[0], np.float64).T
            if is_instancer(prim):
                walk.PruneChildren()
                inner_copies = self._copies_at(prim, frame=None, level=level + 1)
                for name, mesh, local in zip(
                    inner_copies.names, inner_copies.meshes, inner_copies.local[0], strict=True
                ):
                    yield name, mesh, inner @ local
            elif has_surface(prim):
                for mesh in self.geometry.meshes_of(prim):
                    yield prim.GetName(), mesh, inner


def _hides_itself(prim: UsdObject) -> bool:
    """Return True if a prim within a prototype hides itself.

    The visibility of the prototype's ancestors does not count: it often hides all prototypes.
    """
    visibility, purpose = prim.GetAttribute("visibility"), prim.GetAttribute("purpose")
    return bool(visibility and visibility.Get() == "invisible") or bool(
        purpose and purpose.Get() in _HIDDEN_PURPOSES
    )
