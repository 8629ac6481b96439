"""Get the camera of a shot, whether its source is a scene or plates."""

from heatlens.camera.from_shot import camera_before_plates, camera_in_scene
from heatlens.camera.samples import CameraSamples, UpAxis
from heatlens.model.frames import FrameRange
from heatlens.model.shot import Shot
from heatlens.scene.placing import placed
from heatlens.scene.scene_name import open_scene
from heatlens.source.kind import SourceKind, kind_of


def camera_of_shot(
    shot: Shot,
    name: str,
    frames: FrameRange | None = None,
    sensor_height_mm: float | None = None,
    scene_unit_m: float | None = None,
    up_axis: UpAxis = "y",
) -> CameraSamples:
    """Return the camera of `shot` over `frames`; None means the frames that are played.

    In a 3D scene, size and placement are known, in metres and with y up, and `scene_unit_m` and
    `up_axis` are ignored; for plates see `camera_before_plates`. Raises InputError if no frames are
    known or the scene cannot be read, and LensError if keys lead to an impossible lens.
    """
    if shot.source is not None and kind_of(shot.source) is SourceKind.SCENE:
        timing = None if shot.framing is None else shot.framing.timing
        scene = placed(open_scene(shot.source, timing), shot.framing)
        return camera_in_scene(shot, scene, name, frames, sensor_height_mm)
    return camera_before_plates(shot, name, frames, sensor_height_mm, scene_unit_m, up_axis)
