"""A scene seen through a pinhole, as a plate: what a file of that picture would hold."""

import math
from pathlib import Path

import numpy as np

from heatlens.image.plate import CameraHeader, DepthReport, FloatImage, Plate
from heatlens.model.boxes import Box
from heatlens.model.framing import Pose
from heatlens.model.lens import Lens

_MIRRORED_Z = np.diag([1.0, 1.0, -1.0, 1.0])


def plate_of_scene(
    path: Path, color: FloatImage, depth_m: FloatImage, pose: Pose, lens: Lens
) -> Plate:
    """`color` (H, W, 4) and `depth_m` (H, W), +inf for the sky, from where the camera stands."""
    height, width = depth_m.shape
    window = Box(0, 0, width, height)
    return Plate(
        path=path,
        color=color,
        has_alpha=False,
        depth_m=depth_m,
        coc_px=None,
        data_window=window,
        display_window=window,
        pixel_aspect_ratio=1.0,
        camera=_camera(lens, width, height),
        depth=_report(depth_m),
        aovs=("R", "G", "B", "Z"),
        attributes={"worldToCamera": world_to_camera_attribute(pose)},
        notes=(),
    )


def world_to_camera_attribute(pose: Pose) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    """As OpenEXR's standard attribute has it: points are rows, the camera looks along +z."""
    return np.ascontiguousarray((_MIRRORED_Z @ pose.world_to_camera).T, np.float32)


def _camera(lens: Lens, width: int, height: int) -> CameraHeader:
    fields = ("focus_distance_m", "f_stop", "focal_length_mm", "sensor_width_mm")
    return CameraHeader(
        **{name: getattr(lens, name) for name in fields},
        sensor_height_mm=lens.sensor_width_mm * height / width,
        sources=dict.fromkeys(fields, "the scene's camera"),
    )


def _report(depth_m: FloatImage) -> DepthReport:
    finite = depth_m[np.isfinite(depth_m)]
    return DepthReport(
        channel="Z",
        convention="distance",
        kind="planar",
        why="Measured as the scene was drawn.",
        near_m=float(finite.min()) if finite.size else math.inf,
        far_m=float(finite.max()) if finite.size else math.inf,
        infinite_count=int(depth_m.size - finite.size),
        repaired_count=0,
    )
