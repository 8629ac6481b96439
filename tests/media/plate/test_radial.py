"""Test conversion of distance along the ray to planar depth, against the closed form."""

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.boxes import Box
from heatlens.media.plate.depth_read import planar_depth_m
from heatlens.media.plate.header.camera_header import require_lens_mm


def ray_lengths(data, display, aspect, focal_length_mm, sensor_width_mm, depth_m):
    """Return lengths of the rays that end on the plane at `depth_m`, pixel by pixel."""
    lengths = np.empty((data.height, data.width), np.float32)
    pixel_mm = sensor_width_mm / display.width
    for row in range(data.height):
        for column in range(data.width):
            x = (data.x0 + column + 0.5 - display.x0 - display.width / 2) * pixel_mm
            y = (data.y0 + row + 0.5 - display.y0 - display.height / 2) * pixel_mm / aspect
            lengths[row, column] = depth_m * np.hypot(np.hypot(x, y), focal_length_mm)
    return lengths / focal_length_mm


@pytest.mark.parametrize("aspect", [1.0, 2.0])
@pytest.mark.parametrize("data", [Box(0, 0, 9, 5), Box(-4, 2, 6, 9)])
def test_planar_depth_of_frontal_wall_is_constant(data, aspect):
    display = Box(0, 0, 9, 5)
    radial = ray_lengths(data, display, aspect, 35.0, 36.0, 7.0)
    planar = planar_depth_m(
        radial, data, display, pixel_aspect_ratio=aspect, focal_length_mm=35.0, sensor_width_mm=36.0
    )
    assert planar.dtype == np.float32
    np.testing.assert_allclose(planar, 7.0, rtol=1e-6)


def test_planar_depth_keeps_center_and_infinity():
    radial = np.full((3, 3), 4.0, np.float32)
    radial[0, 0] = np.inf
    planar = planar_depth_m(
        radial,
        Box(0, 0, 3, 3),
        Box(0, 0, 3, 3),
        pixel_aspect_ratio=1.0,
        focal_length_mm=50.0,
        sensor_width_mm=36.0,
    )
    assert planar[1, 1] == 4.0 and planar[0, 0] == np.inf
    # A sensor 36 wide in 3 pixels, 50 away: one pixel aside is 12 mm off the axis.
    assert planar[1, 2] == pytest.approx(4 * 50 / (50**2 + 12**2) ** 0.5)


def test_require_lens_mm_names_missing_option():
    assert require_lens_mm("a.exr", 50.0, 36.0) == (50.0, 36.0)
    with pytest.raises(InputError, match="--focal-length"):
        require_lens_mm("a.exr", None, 36.0)
    with pytest.raises(InputError, match="--sensor-width"):
        require_lens_mm("a.exr", 50.0, None)
