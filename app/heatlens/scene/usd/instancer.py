"""Point instancers of USD: many copies of a few prototypes, each with its own transform."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from heatlens.files.usd_library import UsdObject, usd_module
from heatlens.model.curves.frames import FrameRange
from heatlens.scene.scene import Array, check_instances
from heatlens.scene.usd.geometry import UsdGeometry, has_surface
from heatlens.scene.usd.stage import UsdStage

_FAR_MOST = 1e9  # units; beyond it nothing can be drawn
_DEEPEST = 8  # instancers within prototypes of instancers
_HIDDEN = ("guide", "proxy")
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
    """Return True below a point instancer, where prims are prototypes and not drawn directly."""
    parent = prim.GetParent()
    while parent and not parent.IsPseudoRoot():
        if is_instancer(parent):
            return True
        parent = parent.GetParent()
    return False


def changing(prim: UsdObject) -> list[UsdObject]:
    """Return the attributes of an instancer that change over time."""
    attributes = [prim.GetAttribute(name) for name in _ATTRIBUTES]
    return [a for a in attributes if a and a.GetNumTimeSamples() > 1]


@dataclass
class Instancers:
    """Reads the copies that instancers make."""

    stage: UsdStage
    geometry: UsdGeometry
    notes: dict[str, None] = field(default_factory=dict)

    def copies(self, prim: object, frames: FrameRange | None) -> Copies:
        """Return the copies of the instancer over the frames in which its own attributes change.

        Raises InputError if it has too many copies.
        """
        times = list(frames) if frames is not None and changing(prim) else []
        found = self._at(prim, times[0] if times else None, 0)
        locals_ = [found.local]
        for frame in times[1:]:
            other = self._at(prim, frame, 0)
            if other.meshes != found.meshes:
                self.notes["An instancer whose copies come and go keeps its first state."] = None
                return found
            locals_.append(other.local)
        return Copies(found.names, found.meshes, np.concatenate(locals_))

    def _at(self, prim: object, frame: float | None, depth: int) -> Copies:
        """Return the copies at a frame, None for the first; also of instancers in prototypes."""
        usd, geometry = usd_module("Usd"), usd_module("UsdGeom")
        time = usd.TimeCode.EarliestTime() if frame is None else usd.TimeCode(frame)
        instancer = geometry.PointInstancer(prim)
        kinds = np.array(instancer.GetProtoIndicesAttr().Get(time) or [], np.int64)
        check_instances(self.stage.path, len(kinds))
        places = np.array(
            instancer.ComputeInstanceTransformsAtTime(
                time, time, geometry.PointInstancer.IncludeProtoXform,
                geometry.PointInstancer.IgnoreMask,
            ),
            np.float64,
        ).reshape(-1, 4, 4).swapaxes(1, 2)  # fmt: skip
        mask = np.array(instancer.ComputeMaskAtTime(time) or np.ones(len(kinds)), bool)
        if not len(places) == len(kinds) == len(mask):
            self.notes["A point instancer with inconsistent data is left out."] = None
            return Copies((), (), np.zeros((1, 0, 4, 4)))
        is_near = np.asarray((np.abs(places) <= _FAR_MOST).all(axis=(1, 2)))
        if not is_near[mask].all():
            self.notes["Copies of an instancer at infinity or too far away are left out."] = None
        mask &= is_near
        targets = instancer.GetPrototypesRel().GetForwardedTargets()
        names: list[str] = []
        meshes: list[int] = []
        local = [np.zeros((0, 4, 4))]
        for number, path in enumerate(targets):
            of_kind = places[(kinds == number) & mask]
            if not len(of_kind):
                continue
            for name, mesh, inner in self._prototype(path, time, depth):
                names += [name] * len(of_kind)
                meshes += [mesh] * len(of_kind)
                local.append(of_kind @ inner)
                check_instances(self.stage.path, len(names))
        return Copies(tuple(names), tuple(meshes), np.concatenate(local)[None])

    def _prototype(
        self, path: object, time: object, depth: int
    ) -> Iterator[tuple[str, int, Array]]:
        """Yield the meshes of a prototype: name, number, and (4, 4) to the prototype's root."""
        usd, geometry = usd_module("Usd"), usd_module("UsdGeom")
        root = self.stage.stage.GetPrimAtPath(path)
        if not root or depth > _DEEPEST:
            return
        cache = geometry.XformCache(time)
        predicate = usd.TraverseInstanceProxies(usd.PrimIsActive & usd.PrimIsLoaded)
        walk = iter(usd.PrimRange(root, predicate))
        for prim in walk:
            if _is_hidden(prim):
                walk.PruneChildren()
                continue
            inner = np.array(cache.ComputeRelativeTransform(prim, root)[0], np.float64).T
            if is_instancer(prim):
                walk.PruneChildren()
                own = self._at(prim, None, depth + 1)
                for name, mesh, local in zip(own.names, own.meshes, own.local[0], strict=True):
                    yield name, mesh, inner @ local
            elif has_surface(prim):
                for mesh in self.geometry.of(prim):
                    yield prim.GetName(), mesh, inner


def _is_hidden(prim: UsdObject) -> bool:
    """Return True if a prim within a prototype hides itself.

    The visibility of the prototype's ancestors does not count: it often hides all prototypes.
    """
    seen, purpose = prim.GetAttribute("visibility"), prim.GetAttribute("purpose")
    return bool(seen and seen.Get() == "invisible") or bool(purpose and purpose.Get() in _HIDDEN)
