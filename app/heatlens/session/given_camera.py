"""The camera that the command line gave: the shot it is for begins with its lens."""

from collections.abc import Collection
from dataclasses import replace

from heatlens.camera.into_shot import lens_tracks, with_camera
from heatlens.camera.samples import CameraSamples
from heatlens.model.shot import Shot


def first_values(camera: CameraSamples | None, kept: Collection[str]) -> dict[str, float]:
    """Fields of Lens that the camera tells, as they are first, but those in `kept`."""
    if camera is None:
        return {}
    return {name: track[0] for name, track in lens_tracks(camera, kept).items()}


def begun_with_camera(shot: Shot, camera: CameraSamples | None, kept: Collection[str]) -> Shot:
    """Lens, keys and rate of `camera`, and its frames where the shot has none.

    Fields of Lens in `kept` stay. Raises LensError where what stays makes no lens with the rest.
    """
    if camera is None:
        return shot
    return replace(
        with_camera(shot, camera, kept),
        frames=shot.frames or camera.frame_range,
        frames_per_second=camera.frames_per_second,
    )
