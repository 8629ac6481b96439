"""Measure the distance of a point of the scene at each frame, a few frames at a time."""

import time
from dataclasses import dataclass, field

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.marks.marks import PointMark
from heatlens.core.model.shot.shot import Shot
from heatlens.media.scene.scene import Scene
from heatlens.render.frame_renderer import FrameRenderer

_SLICE_S = 0.02


@dataclass(frozen=True)
class PointMeasurement:
    """A measurement in progress, of a mark in the shot as it was at the start."""

    renderer: FrameRenderer
    scene: Scene
    shot: Shot
    mark: PointMark
    frames: FrameRange
    distances_m: dict[int, float] = field(default_factory=dict)  # the measured ones by frame

    @property
    def words(self) -> str:
        """A sentence that says how many frames have been measured."""
        return f"Following {self.mark.name}: {len(self.distances_m)} of {self.frames.count} frames."

    @property
    def is_done(self) -> bool:
        """True once all frames are measured."""
        return len(self.distances_m) == self.frames.count

    def measure_slice(self) -> None:
        """Measure for a short time, at least one frame.

        Raises HeatlensError if a frame has no distance.
        """
        if self.renderer.scene is not self.scene:
            raise InputError(f"{self.mark.name} is not followed: another scene was opened.")
        start = time.perf_counter()
        x, y = int(self.mark.x_px), int(self.mark.y_px)
        while not self.is_done:
            frame = self.frames.first + len(self.distances_m)
            self.distances_m[frame] = self.renderer.scene_depth_m(self.shot, frame, x, y)
            if time.perf_counter() - start > _SLICE_S:
                return
