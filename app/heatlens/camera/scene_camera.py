"""The camera of a shot of a 3D scene: where it stands is known, and not read from headers."""

from dataclasses import replace

from heatlens.camera.placement import Matrix, matrix_of
from heatlens.camera.samples import CameraSamples
from heatlens.camera.shot_lens import lens_camera
from heatlens.model.frames import FrameRange
from heatlens.model.framing import Framing
from heatlens.model.shot import Shot
from heatlens.scene.scene import Scene
from heatlens.scene.scene_bounds import track_of

_STILL = FrameRange(1, 1)


def camera_in_scene(
    shot: Shot,
    scene: Scene,
    name: str,
    frames: FrameRange | None = None,
    sensor_height_mm: float | None = None,
) -> CameraSamples:
    """The lens of `shot` and its place in `scene` over `frames`, else over those that are played.

    The world is the scene's: metres, y up. Raises InputError for a camera that it does not have.
    """
    frames = frames or shot.played or scene.frames or _STILL
    framing = shot.framing or Framing()
    height_mm = sensor_height_mm
    why = "as given"
    if height_mm is None:
        height_mm = shot.lens.sensor_width_mm * framing.height_px / framing.width_px
        why = f"from a picture of {framing.width_px}x{framing.height_px}"
    return replace(
        lens_camera(shot, name, frames),
        sensor_height_mm=(height_mm,) * frames.count,
        world_to_camera=tuple(_placement(shot, scene, framing, frame) for frame in frames),
        notes=(f"sensor height {height_mm:.4g} mm, {why}.", f"placement as in {scene.path}."),
    )


def _placement(shot: Shot, scene: Scene, framing: Framing, frame: int) -> Matrix:
    pose = track_of(scene, framing, shot.lens_at(frame)).pose_at(frame)
    return matrix_of(pose.world_to_camera)
