"""A drawn pinhole picture of a scene as a plate, as if it were read from a file."""

from collections.abc import Callable
from functools import cached_property, lru_cache
from pathlib import Path
from threading import get_ident

import numpy as np

from heatlens.core.base.errors import GpuError
from heatlens.core.model.boxes import Box
from heatlens.core.model.depth_words import DepthConvention, DepthKind
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.camera_track import Pose
from heatlens.media.plate.plate import CameraHeader, DepthReport, Plate
from heatlens.render.gpu.resources import Texture
from heatlens.render.gpu.textures import FloatArray, download
from heatlens.render.scene_gpu.depth_survey import DepthStatistics

_MIRRORED_Z = np.diag([1.0, 1.0, -1.0, 1.0])  # OpenEXR's cameras look along +z, these along -z
_AREAS_MAX = 64  # areas of a picture in the cache

ReadArea = Callable[[Texture, Box], FloatArray]


class DrawnPixels:
    """Pixels on the GPU that are read when they are used; see `Pixels`.

    Once the textures have been overwritten, reading raises GpuError. Reading works on the
    thread that draws; others use `Plate.in_memory`.
    """

    coc_px = None

    def __init__(self, color: Texture, depth: Texture, read_area: ReadArea) -> None:
        """Take RGBA float16 and R float32, and a function that reads an area of either.

        `read_area` returns (h, w, C) or (h, w) float32.
        """
        self._color, self._depth = color, depth
        # The cache serves a pointer that rests on a pixel.
        self._area = lru_cache(_AREAS_MAX)(read_area)
        self._is_valid, self._thread = True, get_ident()

    def invalidate(self) -> None:
        """Forget the textures, because they are overwritten or released now."""
        self._is_valid = False

    @cached_property
    def color(self) -> FloatArray:
        """RGBA of the whole picture (H, W, 4), read on first use."""
        return download(self._require_valid(self._color))

    @cached_property
    def depth_m(self) -> FloatArray:
        """Planar meters of the whole picture (H, W), read on first use."""
        return download(self._require_valid(self._depth))

    def color_in(self, area: Box) -> FloatArray:
        """Return RGBA of an area (h, w, 4)."""
        return self._area(self._require_valid(self._color), area)

    def depth_in(self, area: Box) -> FloatArray:
        """Return planar meters of an area (h, w)."""
        return self._area(self._require_valid(self._depth), area)

    def _require_valid(self, texture: Texture) -> Texture:
        """Return the texture. Raises GpuError if it has been overwritten."""
        assert get_ident() == self._thread, "another thread draws"
        if not self._is_valid:
            raise GpuError(
                "Another frame of the scene was drawn in place of this picture: render its frame "
                "again."
            )
        return texture


def plate_of_scene(
    path: Path,
    pixels: DrawnPixels,
    depths: DepthStatistics,
    view: tuple[Pose, Lens, tuple[int, int]],
    notes: tuple[str, ...],
) -> Plate:
    """Return the plate of a drawn picture.

    `view` is the pose of the camera, its lens, and width and height of the picture; `notes` are on
    surfaces that were left out.
    """
    pose, lens, size = view
    window = Box(0, 0, *size)
    return Plate(
        path=path,
        pixels=pixels,
        has_alpha=False,
        data_window=window,
        display_window=window,
        pixel_aspect_ratio=1.0,
        camera=_camera(lens, *size),
        depth=_depth_report(depths),
        aovs=("R", "G", "B", "Z"),
        attributes={"worldToCamera": world_to_camera_attribute(pose)},
        notes=notes,
        surfaces_lost=" ".join(notes),
    )


def world_to_camera_attribute(pose: Pose) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    """Return OpenEXR's attribute worldToCamera of a pose, (4, 4).

    In OpenEXR points are rows, and cameras look along +z.
    """
    return np.ascontiguousarray((_MIRRORED_Z @ pose.world_to_camera).T, np.float32)


def _camera(lens: Lens, width: int, height: int) -> CameraHeader:
    """Return the header of the lens that the scene was drawn with."""
    fields = ("focus_distance_m", "f_stop", "focal_length_mm", "sensor_width_mm", "model")
    return CameraHeader(
        **{name: getattr(lens, name) for name in fields},
        sensor_height_mm=lens.sensor_width_mm * height / width,
        sources=dict.fromkeys(fields, "the scene's camera"),
    )


def _depth_report(depths: DepthStatistics) -> DepthReport:
    """Return the report on the depth of a drawn picture."""
    return DepthReport(
        channel="Z",
        convention=DepthConvention.DISTANCE,
        kind=DepthKind.PLANAR,
        why="Measured as the scene was drawn.",
        near_m=depths.near_m,
        far_m=depths.far_m,
        infinite_count=depths.infinite_count,
        repaired_count=0,
    )
