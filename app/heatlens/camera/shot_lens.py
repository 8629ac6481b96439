"""The lens of a shot at each frame, as a camera that stands nowhere yet."""

from typing import Any

from heatlens.camera.samples import CameraSamples
from heatlens.model.frames import FrameRange
from heatlens.model.shot import LensParameter, Shot


def lens_camera(shot: Shot, name: str, frames: FrameRange) -> CameraSamples:
    """All of the lens but the height of the sensor.

    Raises LensError where keys ask for what no lens can be.
    """
    lenses = [shot.lens_at(frame) for frame in frames]
    tracks: dict[str, Any] = {
        str(parameter): tuple(float(getattr(lens, parameter)) for lens in lenses)
        for parameter in LensParameter
    }
    return CameraSamples(
        name,
        tuple(frames),
        **tracks,
        sensor_width_mm=(shot.lens.sensor_width_mm,) * frames.count,
        frames_per_second=shot.frames_per_second,
    )
