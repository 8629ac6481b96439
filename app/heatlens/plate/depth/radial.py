"""Convert distances along the rays of a pinhole camera to depth along its optical axis."""

import numpy as np

from heatlens.base.errors import InputError
from heatlens.model.boxes import Box
from heatlens.plate.plate import FloatImage


def planar_depth_m(
    radial_m: FloatImage,
    data_window: Box,
    display_window: Box,
    pixel_aspect_ratio: float,
    focal_length_mm: float,
    sensor_width_mm: float,
) -> FloatImage:
    """Convert distances along the rays to planar metres (H, W) over `data_window`.

    z = r / sqrt(1 + (x/f)^2 + (y/f)^2), with x and y the pixel's centre on the sensor, measured
    from the centre of the display window, whose width is the sensor's. Infinity stays infinity.
    """
    pitch_x = sensor_width_mm / display_window.width / focal_length_mm
    pitch_y = pitch_x / pixel_aspect_ratio
    centre_x = (display_window.x0 + display_window.x1) / 2
    centre_y = (display_window.y0 + display_window.y1) / 2
    x = (np.arange(data_window.x0, data_window.x1) + 0.5 - centre_x) * pitch_x
    y = (np.arange(data_window.y0, data_window.y1) + 0.5 - centre_y) * pitch_y
    stretch = np.sqrt(1 + x[None, :] ** 2 + y[:, None] ** 2)
    planar: FloatImage = (radial_m / stretch).astype(np.float32)
    return planar


def checked_lens_mm(
    path: object, focal_length_mm: float | None, sensor_width_mm: float | None
) -> tuple[float, float]:
    """Return both lengths; raise InputError that names the option for a missing one."""
    if focal_length_mm is None or sensor_width_mm is None:
        missing = "--focal-length" if focal_length_mm is None else "--sensor-width"
        raise InputError(
            f"{path}: radial depth becomes planar only with the lens known, and the header does "
            f"not give it: add {missing} (mm)."
        )
    return focal_length_mm, sensor_width_mm
