"""Get the camera of a shot, whether its source is a scene or plates."""

from heatlens.camera.from_shot import CameraWish
from heatlens.camera.samples import CameraSamples, UpAxis
from heatlens.model.curves.frames import FrameRange
from heatlens.model.shot.shot import Shot
from heatlens.source.kinds import kind_of


def camera_of_shot(
    shot: Shot,
    name: str,
    frames: FrameRange | None = None,
    sensor_height_mm: float | None = None,
    scene_unit_m: float | None = None,
    up_axis: UpAxis = "y",
) -> CameraSamples:
    """Return the camera of `shot`, see `CameraWish`.

    Raises InputError if no frames are known or the scene cannot be read, and LensError if keys lead
    to an impossible lens.
    """
    wish = CameraWish(name, frames, sensor_height_mm, scene_unit_m, up_axis)
    return kind_of(shot.source or "").camera(shot, wish)
