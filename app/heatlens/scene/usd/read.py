"""Meshes, materials and cameras of a USD stage as a scene. A time code is a frame."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from heatlens.errors import InputError
from heatlens.files import usd_values
from heatlens.files.quiet import quiet_library
from heatlens.files.usd_library import read_usd_apart, usd_failures_told, usd_module
from heatlens.model.frames import FrameRange
from heatlens.model.framing import CameraTrack, Pose, PoseKey, pose_of
from heatlens.scene.scene import Array, Instance, Mesh, Scene, SceneCamera
from heatlens.scene.usd.material import UsdMaterials
from heatlens.scene.usd.mesh import read_parts
from heatlens.scene.usd.stage import STILL_FRAME, UsdStage, open_stage

_HIDDEN = ("guide", "proxy")
_MATRICES_MOST = 20_000_000  # of all instances over all frames


@dataclass(frozen=True, eq=False)
class _Sampled:
    """Places (F, P, 4, 4) over frames, and which of them each instance has."""

    first: int
    places: Array
    chosen: tuple[int, ...]

    def __call__(self, frame: float) -> Array:
        """Return (instances, 4, 4), interpolated linearly between two frames."""
        at = min(max(frame - self.first, 0.0), len(self.places) - 1.0)
        before = min(int(at), len(self.places) - 2)
        a, b = self.places[before], self.places[before + 1]
        return np.asarray((a + (b - a) * (at - before))[list(self.chosen)])


def read_usd(path: Path) -> Scene:
    """Run `usd_scene` in a process of its own, and survive a crash of OpenUSD.

    Raises InputError as `usd_scene` does, and where OpenUSD ends that process.
    """
    return read_usd_apart(usd_scene, str(path), path)


def usd_scene(text: str) -> Scene:
    """Read a scene; raise InputError where it is damaged or has nothing visible."""
    path = Path(text)
    with quiet_library(), usd_failures_told(path):
        return _scene(open_stage(path))


def _scene(stage: UsdStage) -> Scene:
    materials = UsdMaterials(stage)
    prims = [prim for prim in stage.prims if _is_seen(prim)]
    meshes, chosen, numbers = _meshes(materials, prims)
    cameras = [prim for prim in stage.prims if prim.IsA(usd_module("UsdGeom").Camera)]
    frames = stage.frames_of([*prims, *cameras])
    moves = frames is not None and stage.frames_of(prims) is not None
    places = _sampled(stage, prims, frames if moves else None)
    names = [prims[number].GetName() for number in chosen]
    return Scene(
        stage.path,
        tuple(meshes),
        tuple(map(Instance, names, numbers, places[0, list(chosen)])),
        tuple(materials.materials),
        tuple(materials.images),
        _cameras(stage, cameras, frames),
        motion=_Sampled(frames.first, places, chosen) if frames and moves else None,
        frames=frames,
        frames_per_second=stage.frames_per_second,
        notes=tuple(f"{stage.path}: {note}" for note in [*_notes(stage), *materials.notes]),
    )


def _is_seen(prim: Any) -> bool:
    geometry = usd_module("UsdGeom")
    if not prim.IsA(geometry.Mesh):
        return False
    seen = geometry.Imageable(prim)
    return seen.ComputeVisibility() != "invisible" and seen.ComputePurpose() not in _HIDDEN


def _meshes(
    materials: UsdMaterials, prims: list[Any]
) -> tuple[list[Mesh], tuple[int, ...], tuple[int, ...]]:
    """Return the meshes, and for each instance the numbers of its prim and its mesh."""
    meshes: list[Mesh] = []
    known: dict[Any, list[int]] = {}
    chosen, numbers = [], []
    for number, prim in enumerate(prims):
        own = prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim
        if own.GetPath() not in known:
            parts = read_parts(materials, prim)
            known[own.GetPath()] = list(range(len(meshes), len(meshes) + len(parts)))
            meshes += parts
        for mesh in known[own.GetPath()]:
            chosen.append(number)
            numbers.append(mesh)
    return meshes, tuple(chosen), tuple(numbers)


def _sampled(stage: UsdStage, prims: list[Any], frames: FrameRange | None) -> Array:
    """Return places (F, P, 4, 4), of one frame where nothing moves."""
    if frames is None:
        return stage.places(prims, STILL_FRAME)[None]
    if frames.count * len(prims) > _MATRICES_MOST:
        raise InputError(f"{stage.path}: too many objects move over {frames.count:,} frames.")
    return np.stack([stage.places(prims, frame) for frame in frames])


def _cameras(
    stage: UsdStage, prims: list[Any], frames: FrameRange | None
) -> tuple[SceneCamera, ...]:
    found: list[SceneCamera] = []
    for prim in prims:
        if prim.GetAttribute("projection").Get() == "orthographic":
            continue
        own = frames if stage.frames_of([prim]) else None
        at = [float(frame) for frame in own] if own else [float(STILL_FRAME)]
        poses = (_pose(stage, prim, frame) for frame in at)
        track = CameraTrack(tuple(map(PoseKey, at, poses)))
        mm = stage.meters_per_unit * 100  # lenses are told in tenths of a unit
        focal_mm, width_mm = (
            usd_values.number(prim.GetAttribute(name).Get(at[0]), f"{stage.path}: {name}") * mm
            for name in ("focalLength", "horizontalAperture")
        )
        if not (0 < focal_mm < math.inf and 0 < width_mm < math.inf):
            raise InputError(f"{stage.path}: {prim.GetPath()} has an impossible lens.")
        names = [camera.name for camera in found]
        name = prim.GetName() if prim.GetName() not in names else str(prim.GetPath())
        found.append(SceneCamera(name, track, focal_mm, width_mm))
    return tuple(found)


def _pose(stage: UsdStage, prim: Any, frame: float) -> Pose:
    """Return the pose of a prim without its parents' scale, upright where they mirror it."""
    matrix = stage.places([prim], frame)[0]
    back, up = matrix[:3, 2], matrix[:3, 1]
    side = np.cross(up, back)
    if not np.linalg.norm(side) > 1e-30:
        raise InputError(f"{stage.path}: {prim.GetPath()} is scaled to zero.")
    matrix[:3, 0], matrix[:3, 1] = side, np.cross(back, side)
    return pose_of(matrix)


def _notes(stage: UsdStage) -> list[str]:
    """Return a note for each part of the stage that is not read."""
    lux, geometry, skeleton = (usd_module(name) for name in ("UsdLux", "UsdGeom", "UsdSkel"))
    kinds = (
        ("Lights of USD are not read; the daylight shines.", lux.BoundableLightBase),
        ("Distant and dome lights of USD are not read.", lux.NonboundableLightBase),
        ("Point instancers are not read.", geometry.PointInstancer),
        ("Skeletons are not read: a figure stands as it was modelled.", skeleton.Skeleton),
    )
    return [note for note, kind in kinds if any(prim.IsA(kind) for prim in stage.prims)]
