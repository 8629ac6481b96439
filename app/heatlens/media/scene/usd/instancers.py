"""Read the copies that the point instancers of a USD stage place."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from heatlens.core.model.curves.frames import FrameRange
from heatlens.media.files.usd_library import UsdObject, usd_module
from heatlens.media.scene.scene import Array, check_instances
from heatlens.media.scene.usd.geometry import (
    HIDDEN_PURPOSES,
    UsdGeometry,
    find_animated_attributes,
    has_surface,
)
from heatlens.media.scene.usd.stage import UsdStage

_FAR_MOST = 1e9  # units; beyond it nothing can be drawn
_LEVELS_MOST = 8  # instancers within prototypes of instancers


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
            return Copies(names=(), meshes=(), local=np.zeros((1, 0, 4, 4)))
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
        return Copies(names=tuple(names), meshes=tuple(meshes), local=np.concatenate(local)[None])

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
        purpose and purpose.Get() in HIDDEN_PURPOSES
    )
