"""An opened OpenUSD stage: its unit, up axis and frames, and the transforms of its prims."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange, check_frame, check_frames_per_second
from heatlens.media.files.usd_library import UsdObject, open_usd, usd_module
from heatlens.media.scene.scene import Array

STILL_FRAME = 1
# Cameras get a key for each frame, and objects a matrix.
_FRAMES_MOST = 100_000


@dataclass(frozen=True)
class UsdStage:
    """An opened USD file.

    to_metres  (4, 4) matrix from the world of the file to that of heatlens: meters, y up
    prims      all defined prims, also those within instances
    notes      sentences for the user, in order, each once
    """

    path: Path
    stage: UsdObject
    prims: list[UsdObject]
    meters_per_unit: float
    to_metres: Array
    frames_per_second: float
    notes: dict[str, None] = field(default_factory=dict)

    def frames_of(
        self, prims: list[UsdObject], attributes: Iterable[UsdObject] = ()
    ) -> FrameRange | None:
        """Return the frames in which a prim or one of its ancestors moves; None if none does.

        The times of further attributes count as well. Raises InputError.
        """
        xformable = usd_module("UsdGeom").Xformable
        moving = (xformable(prim) for prim in _with_ancestors(prims) if prim.IsA(xformable))
        times = {time for xform in (*moving, *attributes) for time in xform.GetTimeSamples()}
        if len(times) < 2:
            return None
        for time in (min(times), max(times)):
            check_frame(time)
        frames = FrameRange(math.floor(min(times)), math.ceil(max(times)))
        if frames.count > _FRAMES_MOST:
            raise InputError(
                f"{self.path} moves over {frames.count:,} frames; heatlens takes {_FRAMES_MOST:,}. "
                "Export fewer frames."
            )
        return frames

    def world_matrices(self, prims: list[object], frame: float) -> Array:
        """Return the matrices (P, 4, 4) from each prim to the world of heatlens at a frame."""
        cache = usd_module("UsdGeom").XformCache(frame)
        rows = np.array([cache.GetLocalToWorldTransform(prim) for prim in prims], np.float64)
        matrices = self.to_metres @ rows.reshape(-1, 4, 4).swapaxes(1, 2)
        if not np.isfinite(matrices).all() or (matrices.size and np.abs(matrices).max() > 1e9):
            raise InputError(
                f"{self.path}: an object is more than a million kilometres away or as large: look "
                "at the unit of the scene."
            )
        return np.asarray(matrices)


def open_stage(path: Path) -> UsdStage:
    """Open a stage; raise InputError if it is not a stage, is damaged, or has no unit."""
    usd, geometry = usd_module("Usd"), usd_module("UsdGeom")
    stage = open_usd(path)
    prims = list(stage.Traverse(usd.TraverseInstanceProxies()))
    unit_m = geometry.GetStageMetersPerUnit(stage)
    up, rate = geometry.GetStageUpAxis(stage), stage.GetTimeCodesPerSecond()
    if not 0 < unit_m < 1e9:
        raise InputError(
            f"{path} has {unit_m:g} metres per unit, so no length can be read: export it with "
            "metersPerUnit above 0."
        )
    check_frames_per_second(rate)
    to_metres = np.diag([unit_m, unit_m, unit_m, 1.0])
    if up == "Z":
        to_metres = to_metres @ [[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]]
    return UsdStage(
        path=path,
        stage=stage,
        prims=prims,
        meters_per_unit=unit_m,
        to_metres=np.asarray(to_metres),
        frames_per_second=rate,
    )


def _with_ancestors(prims: Iterable[UsdObject]) -> Iterable[UsdObject]:
    """Return the prims and all their ancestors, each once."""
    prims_by_path = {}
    for prim in prims:
        while prim and not prim.IsPseudoRoot() and prim.GetPath() not in prims_by_path:
            prims_by_path[prim.GetPath()], prim = prim, prim.GetParent()
    return prims_by_path.values()


def kind_of(prim: UsdObject) -> str:
    """Return the name of a prim's schema, or of its fallback if its type is unknown."""
    return str(prim.GetPrimTypeInfo().GetSchemaTypeName())
