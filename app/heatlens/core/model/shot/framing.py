"""How a scene is viewed: the pose of the camera at each frame, and the size of the picture.

The world is right-handed with y up, in meters; the camera has x to the right, y up, and looks
along -z, as in glTF and USD.
"""

from dataclasses import dataclass, replace
from enum import StrEnum

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import (
    FRAMES_PER_SECOND,
    check_frame,
    check_frames_per_second,
)
from heatlens.core.model.shot.camera_track import CameraTrack, Pose, PoseKey

_UNIT_LEAST_M, _UNIT_MOST_M = 1e-9, 1e9
SIZE_MOST_PX = 16384
ALL_CLIPS = "all at once"  # in place of a clip's name


class WorldAxis(StrEnum):
    """An axis that can point up in a file."""

    X = "x"
    Y = "y"
    Z = "z"


@dataclass(frozen=True, slots=True)
class SceneTiming:
    """How to convert the seconds of a scene's file to frames, for files without frame numbers.

    clip               the animation that is played, by name or by number from 1; None for all
    frames_per_second  frames per second
    first_frame        the frame at the first key of the played animation; None for frame 1 at
                       second 0

    Raises InputError for an impossible frame rate.
    """

    clip: str | None = None
    frames_per_second: float = FRAMES_PER_SECOND
    first_frame: int | None = None

    def __post_init__(self) -> None:
        check_frames_per_second(self.frames_per_second)
        if self.first_frame is not None:
            check_frame(self.first_frame)


@dataclass(frozen=True, slots=True)
class Framing:
    """The view of a scene, in space and in time.

    width_px, height_px  of the picture; pixels are square
    camera               name of the scene's camera that is used, None for none
    track                a camera of the shot's own, which takes precedence over that
    timing               how the seconds of the scene become frames; None for the default
    up_axis              up axis, for files that do not define it
    meters_per_unit      meters in one unit of such a file

    With neither camera nor track, the scene's first camera is used; a scene without cameras is
    shown whole. Raises InputError for an impossible size or unit.
    """

    width_px: int = 1280
    height_px: int = 720
    camera: str | None = None
    track: CameraTrack | None = None
    timing: SceneTiming | None = None
    up_axis: WorldAxis = WorldAxis.Y
    meters_per_unit: float = 1.0

    def __post_init__(self) -> None:
        for side in (self.width_px, self.height_px):
            if not 1 <= side <= SIZE_MOST_PX:
                raise InputError(
                    f"A picture has 1 to {SIZE_MOST_PX} pixels a side, got "
                    f"{self.width_px}x{self.height_px}."
                )
        if not _UNIT_LEAST_M <= self.meters_per_unit <= _UNIT_MOST_M:
            raise InputError(
                f"A unit has {_UNIT_LEAST_M:g} to {_UNIT_MOST_M:g} metres, got "
                f"{self.meters_per_unit:g}."
            )

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) in pixels."""
        return self.width_px, self.height_px

    def scaled(self, scale: float) -> "Framing":
        """Return the framing with a picture scaled by `scale`, of at least one pixel."""
        width, height = (max(1, round(side * scale)) for side in self.size)
        return replace(self, width_px=width, height_px=height)

    def with_pose(self, pose: Pose, frame: float) -> "Framing":
        """Return the framing from another pose.

        A track with several keys gets a key at the frame; otherwise the pose becomes constant.
        """
        track = self.track
        if track is not None and track.is_moving:
            return replace(self, track=track.with_key(frame, pose))
        return replace(self, track=CameraTrack((PoseKey(frame, pose),)))
