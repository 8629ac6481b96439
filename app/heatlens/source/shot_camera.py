"""Get the camera of a shot, whether its source is a scene or plates."""

from heatlens.camera.from_shot import CameraWish, camera_before_plates, camera_in_scene
from heatlens.camera.samples import CameraSamples, UpAxis
from heatlens.model.frames import FrameRange
from heatlens.model.shot import Shot
from heatlens.scene.placing import placed
from heatlens.scene.scene_name import open_scene
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


def camera_of_scene(shot: Shot, wish: CameraWish) -> CameraSamples:
    """Return the camera of a 3D scene, whose size and placement are known."""
    timing = None if shot.framing is None else shot.framing.timing
    scene = placed(open_scene(shot.source or "", timing), shot.framing)
    return camera_in_scene(shot, scene, wish.name, wish.frames, wish.sensor_height_mm)


def camera_of_plates(shot: Shot, wish: CameraWish) -> CameraSamples:
    """Return the camera in front of plates, see `camera_before_plates`."""
    return camera_before_plates(
        shot, wish.name, wish.frames, wish.sensor_height_mm, wish.scene_unit_m, wish.up_axis
    )
