"""The prims of a USD stage that are drawn, and the meshes of each."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

from heatlens.base.errors import InputError
from heatlens.files.usd_library import UsdObject, usd_module
from heatlens.scene.scene import Mesh
from heatlens.scene.usd.curves import read_curves, read_points
from heatlens.scene.usd.material import UsdMaterials
from heatlens.scene.usd.mesh import read_parts
from heatlens.scene.usd.shapes import SHAPE_KINDS, read_shape
from heatlens.scene.usd.stage import kind_of
from heatlens.scene.usd.subdivide import Subdivision

_TOLD_MOST = 8
_HIDDEN = ("guide", "proxy")
_DRAWN = ("Mesh", "BasisCurves", "Points", *SHAPE_KINDS)


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
        return [*told, *([f"Left out for such reasons: {more} more objects."] if more else [])]

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
