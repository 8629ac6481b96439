"""Meshes, materials and cameras of a USD stage as a scene. A time code is a frame."""

from dataclasses import dataclass, replace
from itertools import chain, repeat
from pathlib import Path
from typing import NamedTuple

import numpy as np

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.media.files.quiet import quiet_library
from heatlens.media.files.usd_library import UsdObject, read_usd_in_process, report_usd_failures
from heatlens.media.scene.scene import Array, Instance, Scene, check_instances
from heatlens.media.scene.usd.cameras import find_animated_lens, is_camera, read_cameras
from heatlens.media.scene.usd.files import named_by_usd
from heatlens.media.scene.usd.geometry import (
    UsdGeometry,
    find_animated_attributes,
    has_surface,
    is_shown,
    list_undrawn_kinds,
)
from heatlens.media.scene.usd.instancers import Instancers, is_instancer, is_within_instancer
from heatlens.media.scene.usd.material import UsdMaterials
from heatlens.media.scene.usd.stage import STILL_FRAME, UsdStage, open_stage
from heatlens.media.scene.usd.unread import unread_notes

_MATRICES_MOST = 20_000_000  # matrices of all instances over all frames


@dataclass(frozen=True, eq=False)
class _SampledMotion:
    """The motion of instances: their matrices to the world at any frame.

    first           frame of the first sample
    matrices        (F, P, 4, 4) of P prims over F frames
    matrix_numbers  the number of the prim of each instance
    local           (F or 1, n, 4, 4) of the last n instances, which are copies within their prim,
                    to the prim
    """

    first: int
    matrices: Array
    matrix_numbers: tuple[int, ...]
    local: Array

    def __call__(self, frame: float) -> Array:
        """Return the matrices (instances, 4, 4), interpolated linearly between two frames."""
        index = min(max(frame - self.first, 0.0), max(len(self.matrices) - 1.0, 0.0))
        to_world = _interpolate(self.matrices, index)[list(self.matrix_numbers)]
        copies = self.local.shape[1]
        if copies:
            to_world[-copies:] = to_world[-copies:] @ _interpolate(self.local, index)
        return to_world


def _interpolate(samples: Array, index: float) -> Array:
    """Interpolate the samples (F, ...) linearly at a fractional index."""
    before = min(int(index), max(len(samples) - 2, 0))
    if len(samples) == 1:
        return np.asarray(samples[0])
    a, b = samples[before], samples[before + 1]
    return np.asarray(a + (b - a) * (index - before))


def read_usd(path: Path) -> Scene:
    """Run `usd_scene` in a separate process; this process survives a crash of OpenUSD.

    Raises InputError as `usd_scene` does, and if OpenUSD ends that process.
    """
    return read_usd_in_process(usd_scene, str(path), path)


def usd_scene(text: str) -> Scene:
    """Read a scene; raise InputError where it is damaged or has nothing visible."""
    path = Path(text)
    with quiet_library(), report_usd_failures(path):
        scene = _build_scene(open_stage(path))
    return replace(scene, named_files=named_by_usd(text))


class _Instance(NamedTuple):
    """An instance: its name, its mesh, and the number of its prim or of its instancer."""

    name: str
    mesh: int
    number: int


def _build_scene(stage: UsdStage) -> Scene:
    """Return the scene of a stage: meshes, copies of instancers, cameras, and how they move."""
    materials = UsdMaterials(stage)
    geometry = UsdGeometry(materials)
    instancers = Instancers(stage, geometry)
    outside_instancers = [prim for prim in stage.prims if not is_within_instancer(prim)]
    visible = [prim for prim in outside_instancers if is_shown(prim)]
    prims, instancer_prims = list(filter(has_surface, visible)), list(filter(is_instancer, visible))
    drawn_prims, cameras = [*prims, *instancer_prims], list(filter(is_camera, stage.prims))
    attributes = [*chain.from_iterable(map(find_animated_attributes, instancer_prims))]
    lens_attributes = chain.from_iterable(map(find_animated_lens, cameras))
    frames = stage.frames_of([*drawn_prims, *cameras], [*attributes, *lens_attributes])
    geometry_frames = stage.frames_of(drawn_prims, attributes)
    instances = _instances(geometry, prims)
    copies = [instancers.read_copies(prim, geometry_frames) for prim in instancer_prims]
    for number, copy in enumerate(copies, start=len(prims)):
        instances += map(_Instance, copy.names, copy.meshes, repeat(number))
    check_instances(stage.path, len(instances))
    motion = _SampledMotion(
        first=geometry_frames.first if geometry_frames else STILL_FRAME,
        matrices=_sample_matrices(stage, drawn_prims, geometry_frames),
        matrix_numbers=tuple(instance.number for instance in instances),
        local=_join_copies([copy.local for copy in copies]),
    )
    return Scene(
        stage.path,
        tuple(geometry.meshes),
        tuple(
            Instance(instance.name, instance.mesh, to_world)
            for instance, to_world in zip(instances, motion(motion.first), strict=True)
        ),
        tuple(materials.materials),
        tuple(materials.images),
        read_cameras(stage, cameras, frames),
        motion=motion if geometry_frames else None,
        frames=frames,
        frames_per_second=stage.frames_per_second,
        notes=_notes(stage, geometry, instancers, outside_instancers),
    )


def _instances(geometry: UsdGeometry, prims: list[UsdObject]) -> list[_Instance]:
    """Return an instance for each mesh of the prims that are drawn themselves."""
    return [
        _Instance(prim.GetName(), mesh, number)
        for number, prim in enumerate(prims)
        for mesh in geometry.meshes_of(prim)
    ]


def _notes(
    stage: UsdStage, geometry: UsdGeometry, instancers: Instancers, drawable_prims: list[UsdObject]
) -> tuple[str, ...]:
    """Return the notes of all readers; call this after everything has been read."""
    notes = (
        *(*stage.notes, *geometry.materials.notes, *instancers.notes),
        *(*geometry.notes, *geometry.subdivision.notes),
        *filter(None, (list_undrawn_kinds(drawable_prims),)),
        *unread_notes(stage, drawable_prims),
    )
    return tuple(f"{stage.path}: {note}" for note in notes)


def _join_copies(parts: list[Array]) -> Array:
    """Return the copies of all instancers (F or 1, n, 4, 4), over the frames of the longest."""
    count = max((len(part) for part in parts), default=1)
    if count * sum(part.shape[1] for part in parts) > _MATRICES_MOST:
        raise InputError(
            f"The copies of point instancers move over too many frames, {count:,}: export fewer."
        )
    padded = [part if len(part) == count else np.repeat(part, count, axis=0) for part in parts]
    return np.concatenate(padded, axis=1) if padded else np.zeros((1, 0, 4, 4))


def _sample_matrices(stage: UsdStage, prims: list[object], frames: FrameRange | None) -> Array:
    """Return the matrices (F, P, 4, 4) of prims to the world; F is 1 if nothing moves."""
    if frames is None:
        return stage.world_matrices(prims, STILL_FRAME)[None]
    if frames.count * len(prims) > _MATRICES_MOST:
        raise InputError(
            f"{stage.path}: {len(prims):,} objects move over {frames.count:,} frames, too many. "
            "Export fewer frames."
        )
    return np.stack([stage.world_matrices(prims, frame) for frame in frames])
